#pragma once

#include <cstring>

namespace sluice {

template <int N>
struct Lane
{
    typedef double Vector __attribute__((vector_size(N * sizeof(double))));  // GCC and Clang
};
template <>
struct Lane<1>
{
    using Vector = double;
};

//! L doubles in registers, cut into vectors of 8, 4, 2 and 1: GCC unrolls short loops over arrays before it vectorises
//! them, and then does not (four_point in 3D, three components, gather: 73 ns a point, so 35 ns).
template <int L>
class Lanes
{
 public:
    //! += factor * from[0 .. L)
    void add(double factor, double const* from)
    {
        Vector v;
        std::memcpy(&v, from, sizeof v);
        head_ += factor * v;
        tail_.add(factor, from + width);
    }
    //! to[0 .. L) += factor * this
    void add_to(double factor, double* to) const
    {
        Vector v;
        std::memcpy(&v, to, sizeof v);
        v += factor * head_;
        std::memcpy(to, &v, sizeof v);
        tail_.add_to(factor, to + width);
    }
    void load(double const* from)
    {
        std::memcpy(&head_, from, sizeof head_);
        tail_.load(from + width);
    }
    void store(double* to) const
    {
        std::memcpy(to, &head_, sizeof head_);
        tail_.store(to + width);
    }

 private:
    static constexpr int width = L >= 8 ? 8 : L >= 4 ? 4 : L >= 2 ? 2 : 1;
    using Vector = typename Lane<width>::Vector;
    Vector head_ = {};
    [[no_unique_address]] Lanes<L - width> tail_;
};

template <>
class Lanes<0>
{
 public:
    void add(double, double const*) {}
    void add_to(double, double*) const {}
    void load(double const*) {}
    void store(double*) const {}
};

}  // namespace sluice
