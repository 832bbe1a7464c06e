cimport cython
cimport libc.math as math
from osm2xodr.curves cimport trigonometry

cdef double _PANEL_TURN, _MOST_PANELS, _NEWTON_TOLERANCE, _LEAST_SLOPE, _SHAPE_TOLERANCE, _LEAST_SHAPE_SLOPE
cdef int _NEWTON_ROUNDS, _SERIES_ROUNDS

cpdef void ends(
    const double[:] x,
    const double[:] y,
    const double[:] hdg,
    const double[:] curvature,
    const double[:] rate,
    const double[:] ds,
    double[:, :] out,
) noexcept nogil

cpdef (double, double, double) end(
    double x, double y, double hdg, double curvature, double rate, double ds
) noexcept nogil

cdef (double, double, double) chord(double curvature, double rate, double ds) noexcept nogil

cdef double _sinc(double a) noexcept nogil

cdef (double, double) _unlike_arc(double a, double b) noexcept nogil

cdef double _aside(double a2, double b2) noexcept nogil

@cython.locals(panels=double, count=int, u=double, v=double)
cdef (double, double) _in_panels(double curvature, double rate, double ds) noexcept nogil

@cython.locals(turn=double, aim=double, bend=double, ahead=double)
cpdef void shapes_between(
    const double[:] a,
    const double[:] b,
    const double[:] nodes,
    const double[:] weights,
    double[:] shape,
    double[:] length,
) noexcept nogil

@cython.locals(turn=double, shape=double, ahead=double, off=double, slope=double, step=double)
cdef (double, double) _between(double a, double b, const double[:] nodes, const double[:] weights) noexcept nogil

@cython.locals(s=double, before=double)
cpdef double nearest_on_spiral(
    double curvature, double rate, double length, double u, double v, double guess
) noexcept nogil
