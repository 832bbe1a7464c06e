cimport cython
cimport libc.math as math
from libc.stdint cimport int64_t

cdef double _SHORTEST_EDGE

cpdef void count_cells(const int64_t[:, :, :] cells, int64_t stride, int64_t[:] start) noexcept nogil

cpdef void fill_cells(
    const int64_t[:] at, const int64_t[:, :, :] cells, int64_t stride, int64_t[:] start, int64_t[:] quad, int64_t[:] cell
) noexcept nogil

@cython.locals(alone=bint)
cpdef Py_ssize_t pairs_in_cells(
    const int64_t[:] start,
    const int64_t[:] quad,
    const int64_t[:] cell,
    const double[:, :] box,
    const unsigned char[:] probe,
    const int64_t[:] group,
    int64_t[:] code,
) noexcept nogil

@cython.locals(low=double, high=double)
cdef (double, double) shadow(const double[:, :, :] quads, Py_ssize_t i, double x, double y) noexcept nogil

cpdef void shadows(
    const double[:, :, :] one, const double[:, :, :] other, const double[:, :, :] edges, double[:] depth
) noexcept nogil
