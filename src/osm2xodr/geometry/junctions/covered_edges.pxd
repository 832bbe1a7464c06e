cimport cython
from libc.stdint cimport int64_t

cdef double _GAP_BETWEEN_EDGES, _OVERLAP_OF_LEVELS, _LEVELS_PART_FROM, _FIRST_ENTRY, _BEHIND, _BEYOND, _OUTSIDE
cdef double _PARALLEL, _INFINITE

cpdef void cover_edges(
    const int64_t[:] one,
    const int64_t[:] other,
    const double[:] stations,
    const double[:, :, :] poses,
    const int64_t[:, :] level,
    const double[:] left,
    const double[:] right,
    double[:, :] out,
) noexcept nogil

@cython.locals(entered=bint, near=Py_ssize_t, before=Py_ssize_t, lower=double, upper=double)
cdef void _cover_edge(
    int64_t arm,
    int64_t other,
    const double[:] edge,
    const double[:] stations,
    const double[:, :, :] poses,
    const int64_t[:, :] level,
    const double[:] left,
    const double[:] right,
    Py_ssize_t k,
    double[:, :] out,
) noexcept nogil

@cython.locals(found=Py_ssize_t, least=double, dx=double, dy=double, square=double)
cdef Py_ssize_t _nearest(double x, double y, int64_t arm, const double[:, :, :] poses) noexcept nogil

@cython.locals(changed=bint, other_changed=bint, gap=double, ds=double, dt=double, dx=double, dy=double)
cdef double _outside(
    double x,
    double y,
    int64_t arm,
    Py_ssize_t i,
    int64_t other,
    Py_ssize_t near,
    const double[:] stations,
    const double[:, :, :] poses,
    const int64_t[:, :] level,
    const double[:] left,
    const double[:] right,
) noexcept nogil
