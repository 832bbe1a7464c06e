cimport cython
cimport libc.math as math
from libc.stdint cimport int64_t
from osm2xodr.curves cimport spirals, trigonometry

cdef double _SHORTEST_TANGENT, _LEAST_TURN, _TURN_BACK, _SHORTEST_LINE_BEFORE_ARC, _NO_LINE_BELOW
cdef double _SHORTEST_LINE_BESIDE_ARC, _STRAIGHT_BELOW, _LONGEST_TANGENT, _SHORTEST_RECORD, _MISSED, _MISSED_BY
cdef double _NO_ANGLE, _DRIVEN_RADIUS, _HALF_TURN, _INFINITE

cpdef void connections(
    const double[:] x0,
    const double[:] y0,
    const double[:] hdg0,
    const double[:] x1,
    const double[:] y1,
    const double[:] hdg1,
    const double[:] radius,
    double longest,
    double[:, :, :] out,
    unsigned char[:] missed,
) noexcept nogil

@cython.locals(tangent=double)
cdef double _two_arcs(
    double x0, double y0, double hdg0, double x1, double y1, double hdg1, Py_ssize_t k, double[:, :, :] out
) noexcept nogil

cdef (double, double) _arc(double wx, double wy, double cross, double dot) noexcept nogil

@cython.locals(touch=double, shorter=double)
cdef bint _line_and_arc(
    double x0,
    double y0,
    double hdg0,
    double x1,
    double y1,
    double hdg1,
    double most,
    double longest,
    double sharpest,
    Py_ssize_t k,
    double[:, :, :] out,
) noexcept nogil

@cython.locals(
    missed=bint, bent=bint, turned=double, gone_x=double, gone_y=double, length=double, curvature=double, s=double
)
cdef bint _misses(
    double x0,
    double y0,
    double hdg0,
    double x1,
    double y1,
    double hdg1,
    bint simple,
    Py_ssize_t k,
    double[:, :, :] out,
) noexcept nogil

cdef double _size(double x, double y) noexcept nogil

cdef double _wrapped(double angle) noexcept nogil

@cython.locals(least=double, dx=double, dy=double)
cpdef void least_distances(
    const double[:, :] ax,
    const double[:, :] ay,
    const int64_t[:] row,
    const double[:, :] bx,
    const double[:, :] by,
    const int64_t[:] other,
    double[:] out,
) noexcept nogil

cpdef void meetings_of_tangents(
    const double[:] x0,
    const double[:] y0,
    const double[:] hdg0,
    const double[:] x1,
    const double[:] y1,
    const double[:] hdg1,
    double[:, :] out,
) noexcept nogil

@cython.locals(sine=double)
cdef (double, double) _tangents(
    double x0, double y0, double hdg0, double x1, double y1, double hdg1
) noexcept nogil
