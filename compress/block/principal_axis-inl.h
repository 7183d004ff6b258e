// Principal axis of points in three dimensions, one set of points in each lane.
#if defined(LIGHTCOOK_COMPRESS_PRINCIPAL_AXIS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_PRINCIPAL_AXIS_INL_H_
#undef LIGHTCOOK_COMPRESS_PRINCIPAL_AXIS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_PRINCIPAL_AXIS_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Returns 1 / x to 0.1 %, for all positive normal x but the largest: a linear function of the bits, and two Newton steps.
template <class D>
HWY_INLINE hn::Vec<D> roughInverse(hn::Vec<D> x) {
    const hn::RebindToSigned<D> di;
    const auto two = hn::Set(D(), 2.0f);
    const auto guess = hn::BitCast(D(), hn::Set(di, 0x7EF311C7) - hn::BitCast(di, x));
    const auto better = guess * hn::NegMulAdd(x, guess, two);
    return better * hn::NegMulAdd(x, better, two);
}

/// Adds a point to a covariance (xx xy xz yy yz zz): the products of its coordinates around the mean, times its weight.
template <class D>
HWY_INLINE void addProducts(hn::Vec<D> weight, hn::Vec<D> x, hn::Vec<D> y, hn::Vec<D> z, hn::Vec<D> (&m)[6]) {
    const auto wx = weight * x, wy = weight * y, wz = weight * z;
    m[0] = hn::MulAdd(wx, x, m[0]);
    m[1] = hn::MulAdd(wx, y, m[1]);
    m[2] = hn::MulAdd(wx, z, m[2]);
    m[3] = hn::MulAdd(wy, y, m[3]);
    m[4] = hn::MulAdd(wy, z, m[4]);
    m[5] = hn::MulAdd(wz, z, m[5]);
}

/// Finds the dominant eigenvector of a symmetric matrix (xx xy xz yy yz zz), of any length, by power iteration that starts with the row of
/// the largest diagonal element.
/// normalize  is called before each iteration with the axis
template <class D, class Normalize>
HWY_INLINE void powerIteration(const hn::Vec<D> (&m)[6], int iterations, hn::Vec<D> (&axis)[3], const Normalize& normalize) {
    const auto yFirst = m[3] > m[0], zFirst = m[5] > hn::Max(m[0], m[3]);
    axis[0] = hn::IfThenElse(zFirst, m[2], hn::IfThenElse(yFirst, m[1], m[0]));
    axis[1] = hn::IfThenElse(zFirst, m[4], hn::IfThenElse(yFirst, m[3], m[1]));
    axis[2] = hn::IfThenElse(zFirst, m[5], hn::IfThenElse(yFirst, m[4], m[2]));
    for (int iteration = 0; iteration < iterations; ++iteration) {
        normalize();
        const auto x = axis[0], y = axis[1], z = axis[2];
        axis[0] = hn::MulAdd(m[0], x, hn::MulAdd(m[1], y, m[2] * z));
        axis[1] = hn::MulAdd(m[1], x, hn::MulAdd(m[3], y, m[4] * z));
        axis[2] = hn::MulAdd(m[2], x, hn::MulAdd(m[4], y, m[5] * z));
    }
}

/// Finds the same eigenvector with the largest component about 1.
template <class D>
HWY_INLINE void principalAxis(const hn::Vec<D> (&m)[6], int iterations, hn::Vec<D> (&axis)[3]) {
    const auto normalize = [&] {
        const auto xy = hn::Max(hn::Abs(axis[0]), hn::Abs(axis[1]));
        const auto scale = roughInverse<D>(hn::Max(xy, hn::Max(hn::Abs(axis[2]), hn::Set(D(), 1e-30f))));
        for (int c = 0; c < 3; ++c) axis[c] = axis[c] * scale;
    };
    powerIteration<D>(m, iterations, axis, normalize);
    normalize();
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
