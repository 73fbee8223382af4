#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace mpm {

//! A sum that is rounded once, when it is read: no order of its terms shows in it. A fixed-point number of 512 bits
//! (Kulisch, Computer Arithmetic and Validity (2013), ch. 8, shortened): bits of a term below 2^-256 are dropped, each
//! term's by itself; a term of 2^244 or more, or that is no number, makes it not a number. For up to 2^29 terms.
class ExactSum
{
 public:
    void add(double term)
    {
        if (term == 0) return;
        if (!(std::abs(term) < 0x1p244)) {
            spoilt_ = true;
            return;
        }
        auto const bits = std::bit_cast<std::uint64_t>(term);
        int const exponent = static_cast<int>(bits >> 52 & 0x7ff);
        if (exponent < lowest) return;  // all of it lies below
        std::uint64_t digits = (bits & 0xfffffffffffff) | std::uint64_t{1} << 52;
        int place = exponent - 1075 + 256;  // of its last digit
        if (place < 0) digits >>= -place, place = 0;
        auto const at = static_cast<std::size_t>(place / 32);
        int const shift = place % 32;
        std::uint64_t const low = (digits & 0xffffffff) << shift, high = (digits >> 32) << shift;
        std::int64_t const sign = term < 0 ? -1 : 1;
        part_[at] += sign * static_cast<std::int64_t>(low & 0xffffffff);
        part_[at + 1] += sign * static_cast<std::int64_t>((low >> 32) + (high & 0xffffffff));
        part_[at + 2] += sign * static_cast<std::int64_t>(high >> 32);
    }
    void add(ExactSum const& other)
    {
        for (std::size_t k = 0; k < part_.size(); ++k) part_[k] += other.part_[k];
        spoilt_ = spoilt_ || other.spoilt_;
    }
    double value() const
    {
        if (spoilt_) return std::numeric_limits<double>::quiet_NaN();
        Digits digits{};
        std::copy(part_.begin(), part_.end(), digits.begin() + 2);
        digits = carried(digits);
        bool const below = digits.back() < 0;
        if (below) {
            for (std::int64_t& digit : digits) digit = -digit;
            digits = carried(digits);
        }
        return below ? -rounded(digits) : rounded(digits);
    }

 private:
    using Parts = std::array<std::int64_t, 16>;
    using Digits = std::array<std::int64_t, 19>;    //!< the parts, after two of 0, and what they carry over
    static constexpr int lowest = 1075 - 256 - 52;  //!< exponent, as doubles have it, of 2^-256

    //! The same number with all digits but the last from 0 to 2^32 - 1.
    static Digits carried(Digits digits)
    {
        for (std::size_t k = 0; k + 1 < digits.size(); ++k) {
            digits[k + 1] += digits[k] >> 32;
            digits[k] &= 0xffffffff;
        }
        return digits;
    }
    //! Of digits from 0 to 2^32 - 1: the first 64 bits, of which the last one also says whether any follow.
    static double rounded(Digits const& digits)
    {
        std::size_t top = digits.size() - 1;
        while (top > 2 && digits[top] == 0) --top;
        auto const digit = [&](std::size_t k) { return static_cast<std::uint64_t>(digits[k]); };
        std::uint64_t const first = digit(top) << 32 | digit(top - 1), next = digit(top - 2);
        if (first == 0) return 0;
        int const shift = std::countl_zero(first);
        std::uint64_t const bits = first << shift | (next << shift) >> 32;
        bool more = (next << shift & 0xffffffff) != 0;
        for (std::size_t k = 0; k + 2 < top; ++k) more = more || digits[k] != 0;
        int const place = 32 * (static_cast<int>(top) - 3) - 256 - shift;
        return std::ldexp(static_cast<double>(bits | std::uint64_t{more}), place);
    }

    Parts part_{};  //!< part k counts in 2^(32 k - 256)
    bool spoilt_ = false;
};

}  // namespace mpm
