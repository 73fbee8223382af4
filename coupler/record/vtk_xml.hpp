#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace sluice {

enum class Precision
{
    float32,
    float64
};  //!< of the numbers in a picture file; archives keep float64

//! The arrays of one VTK XML file in raw-appended form: a `<DataArray .../>` line each, and the bytes that go to its
//! end. Source: VTK file formats, "Appended raw": `_` then per array a UInt64 byte count and the little-endian values.
class AppendedArrays
{
 public:
    //! Values as they are, `components` per tuple. Empty `unit`: no unit is stated.
    std::string add(std::string_view name, std::string_view unit, int components, std::span<float const> values);
    std::string add(std::string_view name, std::string_view unit, int components, std::span<std::int64_t const> values);
    //! Tuples of 1, 2 or 3 components; 2 are padded to 3 with zero, because ParaView's vectors have three.
    std::string add_padded(std::string_view name, std::string_view unit, int components, std::span<double const> values,
                           Precision precision);
    std::string add_padded(std::string_view name, std::string_view unit, int components, std::span<float const> values);

    //! The whole file: `type` is PolyData or ImageData, `body` what stands inside `<VTKFile>`.
    std::string document(std::string_view type, std::string_view body) const;

 private:
    template <class To, class From>
    std::string append(std::string_view name, std::string_view unit, int components, int shown,
                       std::span<From const> values);
    std::string bytes_;
};

//! `text` with & < > " replaced, for an XML attribute or text.
std::string xml_escaped(std::string_view text);

}  // namespace sluice
