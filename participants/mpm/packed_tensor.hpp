#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "coupler/base/pack.hpp"

//! Vectors and tensors of four points at a time.
namespace mpm {

using sluice::packs::all;
using sluice::packs::bits;
using sluice::packs::either;
using sluice::packs::load;
using sluice::packs::madd;
using sluice::packs::Pack;
using sluice::packs::PackMask;
using sluice::packs::store;

template <int D>
struct PackVec
{
    Pack part[D]{};
    Pack& operator[](int a) { return part[a]; }
    Pack const& operator[](int a) const { return part[a]; }
};

template <int D>
[[gnu::always_inline]] inline Pack dot(PackVec<D> const& a, PackVec<D> const& b)
{
    Pack sum = a[0] * b[0];
    for (int k = 1; k < D; ++k) sum = madd(a[k], b[k], sum);
    return sum;
}

template <int D>
struct PackMat
{
    Pack part[D][D]{};
    Pack& operator()(int a, int b) { return part[a][b]; }
    Pack const& operator()(int a, int b) const { return part[a][b]; }
};

//! What a scaled one becomes, plus the identity: I + scale a.
template <int D>
[[gnu::always_inline]] inline PackMat<D> one_plus(PackMat<D> const& a, Pack scale)
{
    PackMat<D> out;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) out(i, j) = i == j ? madd(scale, a(i, j), all(1)) : scale * a(i, j);
    return out;
}

template <int D>
[[gnu::always_inline]] inline PackMat<D> product(PackMat<D> const& a, PackMat<D> const& b)
{
    PackMat<D> out;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) {
            Pack sum = a(i, 0) * b(0, j);
            for (int k = 1; k < D; ++k) sum = madd(a(i, k), b(k, j), sum);
            out(i, j) = sum;
        }
    return out;
}

//! Inverse times determinant.
[[gnu::always_inline]] inline PackMat<2> adjugate(PackMat<2> const& a)
{
    PackMat<2> out;
    out(0, 0) = a(1, 1), out(0, 1) = -a(0, 1), out(1, 0) = -a(1, 0), out(1, 1) = a(0, 0);
    return out;
}
[[gnu::always_inline]] inline PackMat<3> adjugate(PackMat<3> const& a)
{
    PackMat<3> out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            int const p = (j + 1) % 3, q = (j + 2) % 3, r = (i + 1) % 3, s = (i + 2) % 3;
            out(i, j) = a(p, r) * a(q, s) - a(p, s) * a(q, r);
        }
    return out;
}
template <int D>
[[gnu::always_inline]] inline Pack determinant(PackMat<D> const& a, PackMat<D> const& adjugate_of_a)
{
    Pack sum = a(0, 0) * adjugate_of_a(0, 0);
    for (int k = 1; k < D; ++k) sum = madd(a(0, k), adjugate_of_a(k, 0), sum);
    return sum;
}
template <int D>
[[gnu::always_inline]] inline Pack determinant(PackMat<D> const& a)
{
    return determinant(a, adjugate(a));
}

//! Cauchy's stress: xx, yy, zz, xy and, in space, xz, yz. In the plane zz acts across it.
template <int D>
struct PackStress
{
    static constexpr std::size_t count = D == 2 ? 4 : 6;
    Pack part[count]{};

    static constexpr std::size_t at(int i, int j) { return static_cast<std::size_t>(i == j ? i : i + j + 2); }
    Pack& operator()(int i, int j) { return part[at(i, j)]; }
    Pack const& operator()(int i, int j) const { return part[at(i, j)]; }
    Pack trace() const { return part[0] + part[1] + part[2]; }
};

//! A turn Q by its skew half, as tensor.hpp makes it of the skew part of G: Q = (I - W/2)^-1 (I + W/2); s = Q s Q^T.
//! `g` is G.
[[gnu::always_inline]] inline void turn(PackStress<2>& s, PackMat<2> const& g)
{
    Pack const one = all(1), spin = all(0.25) * (g(0, 1) - g(1, 0));
    Pack const norm = one / (one + spin * spin);
    Pack const cosine = (one - spin * spin) * norm, sine = all(2) * spin * norm;
    Pack const cos2 = cosine * cosine - sine * sine, sin2 = all(2) * cosine * sine;
    Pack const mean = all(0.5) * (s(0, 0) + s(1, 1)), difference = all(0.5) * (s(0, 0) - s(1, 1));
    Pack const turned = cos2 * difference + sin2 * s(0, 1);
    s(0, 1) = cos2 * s(0, 1) - sin2 * difference;
    s(0, 0) = mean + turned, s(1, 1) = mean - turned;
}
[[gnu::always_inline]] inline void turn(PackStress<3>& s, PackMat<3> const& g)
{
    // W/2 = c x (cross product): Q = I + 2 (C + C^2)/(1 + c^2), C^2 = c c^T - c^2 I
    Pack const quarter = all(0.25);
    Pack const c[3] = {quarter * (g(2, 1) - g(1, 2)), quarter * (g(0, 2) - g(2, 0)), quarter * (g(1, 0) - g(0, 1))};
    Pack const square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2], scale = all(2) / (all(1) + square);
    PackMat<3> q;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) q(i, j) = scale * c[i] * c[j];
    for (int i = 0; i < 3; ++i) q(i, i) += all(1) - scale * square;
    for (int i = 0; i < 3; ++i) {
        int const j = (i + 1) % 3, k = (i + 2) % 3;
        q(k, j) += scale * c[i], q(j, k) -= scale * c[i];
    }
    PackMat<3> half;  // Q s
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) half(i, j) = q(i, 0) * s(0, j) + q(i, 1) * s(1, j) + q(i, 2) * s(2, j);
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) s(i, j) = half(i, 0) * q(j, 0) + half(i, 1) * q(j, 1) + half(i, 2) * q(j, 2);
}

//! Principal stresses, s1 >= s2 >= s3, and the way back to the axes.
template <int D>
struct PackPrincipal;

//! Of the plane, in closed form; zz is one of them.
template <>
struct PackPrincipal<2>
{
    Pack s1, s2, s3;

    explicit PackPrincipal(PackStress<2> const& s)
    {
        using sluice::packs::larger, sluice::packs::smaller;
        Pack const zz = s(2, 2), mean = all(0.5) * (s(0, 0) + s(1, 1));
        half_ = all(0.5) * (s(0, 0) - s(1, 1));
        radius_ = sluice::packs::root(madd(half_, half_, s(0, 1) * s(0, 1)));
        Pack const p1 = mean + radius_, p3 = mean - radius_;
        s1 = larger(p1, zz), s3 = smaller(p3, zz), s2 = larger(smaller(p1, zz), p3);
        highest_ = zz >= p1, lowest_ = ~highest_ & (zz <= p3);
    }
    //! Other values in the same directions.
    void set(PackStress<2>& s, Pack t1, Pack t2, Pack t3, PackMask where) const
    {
        Pack const in1 = either(highest_, t2, t1), in3 = either(lowest_, t2, t3);
        Pack const zz = either(highest_, t1, either(lowest_, t3, t2));
        Pack const share = either(radius_ > all(0), all(0.5) * (in1 - in3) / radius_, all(0));
        Pack const mean = all(0.5) * (in1 + in3);
        s(0, 0) = either(where, madd(share, half_, mean), s(0, 0));
        s(1, 1) = either(where, mean - share * half_, s(1, 1));
        s(2, 2) = either(where, zz, s(2, 2));
        s(0, 1) = either(where, share * s(0, 1), s(0, 1));
    }

 private:
    Pack half_, radius_;
    PackMask highest_, lowest_;  //!< where zz is
};

//! Of space, by Jacobi's rotations. Source: Golub and Van Loan, Matrix Computations (1996), sec. 8.4.
template <>
struct PackPrincipal<3>
{
    Pack s1, s2, s3;

    explicit PackPrincipal(PackStress<3> s)
    {
        for (int i = 0; i < 3; ++i) way_[i][i] = all(1);
        Pack const size = magnitude(s(0, 0)) + magnitude(s(1, 1)) + magnitude(s(2, 2)) + aside(s);
        Pack const enough = all(1e-17) * size;
        for (int sweep = 0; sweep < most_sweeps && bits(aside(s) > enough); ++sweep)
            rotate(s, 0, 1), rotate(s, 0, 2), rotate(s, 1, 2);
        s1 = s(0, 0), s2 = s(1, 1), s3 = s(2, 2);
        order(s1, s2, 0, 1), order(s2, s3, 1, 2), order(s1, s2, 0, 1);
    }
    void set(PackStress<3>& s, Pack t1, Pack t2, Pack t3, PackMask where) const
    {
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j) {
                Pack const sum =
                    madd(t1 * way_[i][0], way_[j][0], madd(t2 * way_[i][1], way_[j][1], t3 * way_[i][2] * way_[j][2]));
                s(i, j) = either(where, sum, s(i, j));
            }
    }

 private:
    static constexpr int most_sweeps = 10;  //!< five do for doubles

    static Pack magnitude(Pack a) { return sluice::packs::larger(a, -a); }
    static Pack aside(PackStress<3> const& s) { return magnitude(s(0, 1)) + magnitude(s(0, 2)) + magnitude(s(1, 2)); }

    //! Makes s(p, q) zero: tan t of the smaller angle of tan 2t = 2 s(p, q) / (s(q, q) - s(p, p)).
    [[gnu::always_inline]] void rotate(PackStress<3>& s, int p, int q)
    {
        Pack const off = s(p, q), apart = s(q, q) - s(p, p), one = all(1), zero{};
        Pack const both = magnitude(apart) + sluice::packs::root(madd(apart, apart, all(4) * off * off));
        Pack const twice = either(apart < zero, -off, off) * all(2);
        Pack const t = either(both > zero, twice / either(both > zero, both, one), zero);
        Pack const c = one / sluice::packs::root(madd(t, t, one)), sine = t * c;
        s(p, p) -= t * off, s(q, q) += t * off, s(p, q) = zero;
        int const r = 3 - p - q;
        Pack const rp = s(std::min(r, p), std::max(r, p)), rq = s(std::min(r, q), std::max(r, q));
        s(std::min(r, p), std::max(r, p)) = c * rp - sine * rq;
        s(std::min(r, q), std::max(r, q)) = madd(sine, rp, c * rq);
        for (auto& row : way_) {
            Pack const a = row[p], b = row[q];
            row[p] = c * a - sine * b, row[q] = madd(sine, a, c * b);
        }
    }
    [[gnu::always_inline]] void order(Pack& first, Pack& second, int a, int b)
    {
        PackMask const right = first >= second;
        Pack const one = first, other = second;
        first = either(right, one, other), second = either(right, other, one);
        for (auto& row : way_) {
            Pack const x = row[a], y = row[b];
            row[a] = either(right, x, y), row[b] = either(right, y, x);
        }
    }

    Pack way_[3][3]{};  //!< directions as columns
};

}  // namespace mpm
