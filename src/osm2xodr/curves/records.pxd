cimport cython
cimport libc.math as math
from libc.stdint cimport int64_t
from osm2xodr.curves cimport spirals, trigonometry

cdef double _GAP, _INFINITE

cpdef void records_at(
    const int64_t[:] start, const double[:] record_s, const int64_t[:] curve, const double[:] s, int64_t[:] out
) noexcept nogil

cdef int64_t record_at(const double[:] record_s, int64_t first, int64_t end, double s) noexcept nogil

cpdef void poses(
    const int64_t[:] start,
    const double[:] record_s,
    const double[:] x,
    const double[:] y,
    const double[:] hdg,
    const double[:] curvature,
    const double[:] rate,
    const int64_t[:] curve,
    const double[:] s,
    double[:, :] out,
) noexcept nogil

@cython.locals(least=double, best=double, nearest=double, dx=double, dy=double, sine=double, cosine=double)
cpdef void projections(
    const int64_t[:] start,
    const double[:] s,
    const double[:] x,
    const double[:] y,
    const double[:] hdg,
    const double[:] length,
    const double[:] curvature,
    const double[:] rate,
    const int64_t[:] curve,
    const double[:] px,
    const double[:] py,
    double[:, :] out,
) noexcept nogil

@cython.locals(along=double)
cdef double nearest_on_record(double curvature, double rate, double length, double u, double v) noexcept nogil

cdef double _apart(double x, double y) noexcept nogil
