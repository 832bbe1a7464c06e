cimport cython
from libc.stdint cimport int64_t

cdef double _INFINITE

@cython.locals(least=double, dx=double, dy=double, square=double)
cpdef void nearest_places(
    const double[:, :] px, const double[:, :] py, const double[:, :] x, const double[:, :] y, int64_t[:, :] out
) noexcept nogil
