cimport cython
cimport libc.math as math
from libc.stdint cimport int64_t
from osm2xodr.curves cimport spirals, trigonometry

cdef double _CELL, _HALF_OF_THEM, _PER_OWN_BEYOND, _PER_MEETING, _OWN, _MEET, _APART
cdef int64_t _OFFSETS, _SQUARE_BITS

@cython.locals(column=int64_t, line=int64_t)
cdef int64_t _square(int64_t junction, double x, double y) noexcept nogil

cpdef void squares_across(
    const int64_t[:] junction,
    const double[:, :] places,
    const double[:] width,
    const double[:] steps,
    int64_t[:, :] out,
) noexcept nogil

cdef bint _is_paved(const int64_t[:] paved, int64_t square) noexcept nogil

@cython.locals(share=double, width=double, sine=double, cosine=double, t=double, own=double)
cpdef double own_tarmac(
    const double[:, :] places,
    double length,
    double entry_width,
    double exit_width,
    int64_t junction,
    const int64_t[:] paved,
) noexcept nogil

cpdef double cost_of_ground(double own) noexcept nogil

@cython.locals(x=double, y=double, hdg=double, behind=double, ahead=double, step=double, s=double)
cpdef void places_on_way(
    const double[:] begin,
    const double[:, :] length,
    const double[:, :] curvature,
    Py_ssize_t way,
    double margin,
    double[:, :] out,
) noexcept nogil

@cython.locals(least=double, dx=double, dy=double)
cpdef double cost_of_meeting(const double[:, :] places, const double[:, :] beside) noexcept nogil

cpdef double rounded(double cost) noexcept nogil

@cython.locals(whole=double, cost=double)
cpdef Py_ssize_t cheapest_way(
    double best,
    const double[:] begin,
    const double[:, :] length,
    const double[:, :] curvature,
    const double[:] bounds,
    double[:] ground,
    double entry_width,
    double exit_width,
    int64_t junction,
    const int64_t[:] paved,
    const double[:, :] beside,
    double[:, :] places,
) noexcept nogil
