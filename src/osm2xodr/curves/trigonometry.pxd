cimport cython
cimport libc.math as math

cdef double _ROUNDER, _PER_QUARTER, _QUARTER_1, _QUARTER_2, _QUARTER_3, _LARGEST, _TURN
cdef double _PI, _PI_REST, _QUARTER, _QUARTER_REST, _EIGHTH, _EIGHTH_REST, _OF_HALF, _OF_HALF_REST

cdef double _within_a_turn(double x) noexcept nogil

cpdef (double, double) sine_cosine(double x) noexcept nogil

@cython.locals(u=double, base=double, rest=double, more=double)
cpdef double arctangent(double y, double x) noexcept nogil

cpdef double wrap(double angle) noexcept nogil

cpdef void sines(const double[:] x, double[:] out) noexcept nogil

cpdef void cosines(const double[:] x, double[:] out) noexcept nogil

cpdef void directions(const double[:] x, double[:] along, double[:] across) noexcept nogil

cpdef void arctangents(const double[:] y, const double[:] x, double[:] out) noexcept nogil
