#pragma once

#include <utility>
#include <vector>

#include "participants/dem/random.hpp"

namespace dem {

//! How the diameters of grains are distributed. Each law is one of number: how many grains are finer than d.
class Sizes
{
 public:
    Sizes() = default;
    //! Every diameter from low to high [m] alike, by number.
    static Sizes uniform_number(double low, double high);
    //! The number coarser than d goes with d^-exponent, between low and high; exponent: the fractal dimension.
    static Sizes fractal(double low, double high, double exponent);
    //! Every diameter alike, by mass, which goes with d^dimension.
    static Sizes uniform_mass(double low, double high, int dimension);
    //! ln d is normal, cut off at low and high; mean and standard deviation [m] are those of d before the cut.
    static Sizes lognormal(double mean, double deviation, double low, double high);
    //! A grading curve: points (d, part by mass that is finer), from 0 to 1; straight in ln d between them.
    static Sizes grading(std::vector<std::pair<double, double>> const& curve, int dimension);

    double draw(Random& random) const;
    double moment(int power) const;       //!< mean of d^power by number [m^power]
    double finer(double diameter) const;  //!< part by number
    double kept() const;                  //!< lognormal: the part that lies between the cuts
    bool is_uniform_number() const { return kind_ == Kind::uniform; }
    double low() const { return pieces_.front().low; }
    double high() const { return pieces_.back().high; }
    //! All that tells this law from another one.
    std::vector<double> numbers() const;

 private:
    enum class Kind
    {
        uniform,
        pieces,
        lognormal
    };
    //! Between low and high the number coarser goes with d^-exponent; `weight`: part of all grains.
    struct Piece
    {
        double low = 0.0, high = 0.0, exponent = 0.0, weight = 1.0;
    };
    double normal(double diameter, double shift = 0.0) const;

    Kind kind_ = Kind::uniform;
    std::vector<Piece> pieces_{{}};
    double log_mean_ = 0.0, log_deviation_ = 0.0;  //!< of ln(d / m)
};

}  // namespace dem
