cimport cython

@cython.locals(rest=double)
cpdef void eliminate(double[:, :] matrix, double[:] out) noexcept nogil
