#pragma once

/// Makes Eigen allocate memory the same way in every program that shares objects with Samara.
///
/// Eigen reads from the compiler's flags how it aligns its arrays, and with AVX it allocates them in a way of
/// its own: what one side allocated the other could not free. Samara is built for 16 bytes, which malloc
/// gives. With flags for AVX this header makes Eigen take the vectors of SSE, of the same 16 bytes; all other
/// code of the program may use AVX. The targets of CMake pass it to the compiler in front of every source of
/// their users (-include). Who calls the compiler by hand does the same, and sets EIGEN_MAX_ALIGN_BYTES to
/// 16.

#if defined(__AVX__) && !defined(EIGEN_DONT_VECTORIZE)

#if defined(EIGEN_CONFIGURE_VECTORIZATION_H)
#if EIGEN_DEFAULT_ALIGN_BYTES != 16
#error "Eigen was included before samara/base/eigen_alignment.h, and allocates otherwise than Samara"
#endif
#else

#include <Eigen/src/Core/util/Macros.h>

#pragma push_macro("__AVX__")
#pragma push_macro("__AVX2__")
#pragma push_macro("__AVX512F__")
#pragma push_macro("__FMA__")
#pragma push_macro("__F16C__")
#undef __AVX__
#undef __AVX2__
#undef __AVX512F__
#undef __FMA__
#undef __F16C__
#include <Eigen/src/Core/util/ConfigureVectorization.h>
#pragma pop_macro("__AVX__")
#pragma pop_macro("__AVX2__")
#pragma pop_macro("__AVX512F__")
#pragma pop_macro("__FMA__")
#pragma pop_macro("__F16C__")

#endif
#endif
