cimport cython
from libc.stdint cimport int64_t

cdef double _INFINITE

@cython.locals(rest=double)
cpdef void eliminate(double[:, :] matrix, double[:] out) noexcept nogil

@cython.locals(n=Py_ssize_t, k=Py_ssize_t, i=Py_ssize_t, a=Py_ssize_t, b=Py_ssize_t)
cpdef void add_squares(
    const double[:, :] terms, const double[:] value, double[:, :] matrix, double[:] right
) noexcept nogil

@cython.locals(first=int64_t, last=int64_t, i=int64_t, half=int64_t)
cpdef void average(
    const int64_t[:] start, const double[:] spacing, const double[:] total, const double[:] width, double[:] out
) noexcept nogil

@cython.locals(least=double)
cpdef void grade(const double[:] at, const double[:] value, double[:] out) noexcept nogil
