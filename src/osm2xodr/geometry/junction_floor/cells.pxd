cimport cython
from libc.stdint cimport int32_t, int64_t

cdef int32_t _cell(float t, float along, float begin) noexcept nogil

cdef float _between(float low, float high, float share) noexcept nogil

@cython.locals(row=int32_t, column=int32_t)
cpdef void draw_across(
    const int64_t[:] sections,
    const float[:] shares,
    const float[:] low,
    const float[:] high,
    const float[:] x,
    const float[:] y,
    const float[:] nx,
    const float[:] ny,
    const int32_t[:] first,
    const int32_t[:] across,
    const int32_t[:] value,
    int32_t[:] out,
) noexcept nogil
