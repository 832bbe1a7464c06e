cimport cython
from libc.stdint cimport int64_t

@cython.locals(row=Py_ssize_t, at=Py_ssize_t, node=Py_ssize_t)
cpdef void elimination_tree(
    const int64_t[:] start, const int64_t[:] column, int64_t[:] parent, int64_t[:] count, int64_t[:] seen
) noexcept nogil

@cython.locals(
    size=Py_ssize_t, row=Py_ssize_t, at=Py_ssize_t, node=Py_ssize_t, top=Py_ssize_t, depth=Py_ssize_t,
    place=Py_ssize_t, end=Py_ssize_t, pivot=double, value=double, share=double,
)
cpdef void factorise(
    const int64_t[:] start,
    const int64_t[:] column,
    const double[:] matrix,
    const int64_t[:] parent,
    const int64_t[:] first,
    int64_t[:] filled,
    int64_t[:] seen,
    int64_t[:] stack,
    double[:] line,
    int64_t[:] rows,
    double[:] lower,
    double[:] diagonal,
) noexcept nogil

@cython.locals(size=Py_ssize_t, at=Py_ssize_t, node=Py_ssize_t, value=double)
cpdef void substitute(
    const int64_t[:] first, const int64_t[:] rows, const double[:] lower, const double[:] diagonal, double[:] out
) noexcept nogil
