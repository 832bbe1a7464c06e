cimport cython
from libc.stdint cimport int64_t

cdef double _INFINITE

@cython.locals(begin=Py_ssize_t, end=Py_ssize_t, bit=int64_t)
cdef (Py_ssize_t, Py_ssize_t) part_of_node(int64_t node, Py_ssize_t points) noexcept nogil

@cython.locals(low=double, high=double, value=double, size=double, widest=Py_ssize_t)
cpdef void halve(const double[:, ::1] points, int64_t[::1] row, double[:, :, ::1] box) noexcept nogil

@cython.locals(value=double, other=int64_t, i=Py_ssize_t, j=Py_ssize_t)
cdef void part(
    const double[:, ::1] points, int64_t[::1] row, Py_ssize_t side, Py_ssize_t first, Py_ssize_t last, Py_ssize_t middle
) noexcept nogil

@cython.locals(out=double, off=double)
cdef double from_box(
    const double[:, :, ::1] box, Py_ssize_t node, const double[:, ::1] places, Py_ssize_t k
) noexcept nogil

@cython.locals(out=double, off=double)
cdef double from_point(
    const double[:, ::1] points, Py_ssize_t at, const double[:, ::1] places, Py_ssize_t k
) noexcept nogil

@cython.locals(count=Py_ssize_t, waiting=Py_ssize_t, node=Py_ssize_t)
cpdef void points_within(
    const double[:, ::1] points,
    const int64_t[::1] row,
    const double[:, :, ::1] box,
    const double[:, ::1] places,
    const double[::1] limit,
    int64_t[::1] start,
    int64_t[::1] found,
    int64_t[::1] queue,
) noexcept nogil

@cython.locals(
    waiting=Py_ssize_t, node=Py_ssize_t, one=double, other=double, nearer=Py_ssize_t, distance=double, index=int64_t,
    place=Py_ssize_t,
)
cpdef void nearest_points(
    const double[:, ::1] points,
    const int64_t[::1] row,
    const double[:, :, ::1] box,
    const double[:, ::1] places,
    double[:, ::1] away,
    int64_t[:, ::1] found,
    int64_t[::1] queue,
    double[::1] least,
) noexcept nogil
