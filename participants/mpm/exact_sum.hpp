#pragma once

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
        auto digits = carried(part_);
        bool const below = digits.back() < 0;
        if (below) {
            for (std::int64_t& digit : digits) digit = -digit;
            digits = carried(digits);
        }
        double sum = 0;
        for (std::size_t k = digits.size(); k-- > 0;)
            sum += std::ldexp(static_cast<double>(digits[k]), 32 * static_cast<int>(k) - 256);
        return below ? -sum : sum;
    }

 private:
    using Parts = std::array<std::int64_t, 16>;
    static constexpr int lowest = 1075 - 256 - 52;  //!< exponent, as doubles have it, of 2^-256

    //! The same number with all parts but the last from 0 to 2^32 - 1.
    static Parts carried(Parts parts)
    {
        for (std::size_t k = 0; k + 1 < parts.size(); ++k) {
            parts[k + 1] += parts[k] >> 32;
            parts[k] &= 0xffffffff;
        }
        return parts;
    }

    Parts part_{};  //!< part k counts in 2^(32 k - 256)
    bool spoilt_ = false;
};

}  // namespace mpm
