cimport cython
from libc.stdint cimport int32_t, int64_t

cdef int32_t _FREE, _FACE
cdef double _FAR

@cython.locals(
    k=int64_t, axis=int64_t, row=int64_t, one=int64_t, wide=int64_t, first=int64_t, cell=int64_t, x=double, y=double,
    dx=double, dy=double, south=double, north=double, left=double, right=double, share=double,
)
cpdef void draw_pieces(
    const int64_t[:] pieces, const double[:, :] places, const double[:, :] t, const int64_t[:, :] grids,
    const int32_t[:] value, int32_t[:] cells, unsigned char[:] beside_gap, double[:, :] corners,
) noexcept nogil

cdef int64_t _behind(double place) noexcept nogil

@cython.locals(k=int64_t, step=int64_t, cell=int64_t)
cpdef void gaps_beside(
    const double[:, :] rays, const int64_t[:, :] grids, int64_t most, const int32_t[:] cells, int64_t[:, :] out
) noexcept nogil

@cython.locals(k=int64_t, step=int64_t)
cpdef void walk_gaps(
    const double[:, :] rays, const int64_t[:, :] grids, const int64_t[:] gap, const int64_t[:, :] span,
    const int32_t[:] cells, int64_t[:, :] out,
) noexcept nogil

@cython.locals(k=int64_t, step=int64_t)
cpdef void close_gaps(
    const double[:, :] rays, const int64_t[:, :] grids, const int64_t[:, :] span, int32_t[:] cells
) noexcept nogil

@cython.locals(column=int64_t, row=int64_t, cell=int64_t)
cdef int64_t _cell(const double[:, :] rays, const int64_t[:, :] grids, int64_t k, int64_t step) noexcept nogil
