#include "coupler/record/vtk_xml.hpp"

#include <fmt/format.h>

#include <bit>
#include <cassert>
#include <cstring>
#include <type_traits>

namespace sluice {
namespace {

static_assert(std::endian::native == std::endian::little, "VTK files are written in the machine's own byte order");

template <class Value>
constexpr std::string_view vtk_type()
{
    if constexpr (std::is_same_v<Value, float>) return "Float32";
    if constexpr (std::is_same_v<Value, double>) return "Float64";
    return "Int64";
}

template <class Value>
void put(std::string& bytes, Value value)
{
    char raw[sizeof(Value)];
    std::memcpy(raw, &value, sizeof(Value));
    bytes.append(raw, sizeof(Value));
}

int padded(int components)
{
    return components == 2 ? 3 : components;
}

}  // namespace

//! `shown` components are stored per tuple of `components`; the others are zero.
template <class To, class From>
std::string AppendedArrays::append(std::string_view name, std::string_view unit, int components, int shown,
                                   std::span<From const> values)
{
    auto const given = static_cast<std::size_t>(components);
    auto const stored = static_cast<std::size_t>(shown);
    assert(values.size() % given == 0 && stored >= given);
    std::size_t const tuples = values.size() / given;
    std::size_t const offset = bytes_.size();
    std::size_t const length = tuples * stored * sizeof(To);
    bytes_.reserve(offset + sizeof(std::uint64_t) + length);
    put(bytes_, static_cast<std::uint64_t>(length));
    if constexpr (std::is_same_v<To, From>) {
        if (given == stored && !values.empty()) bytes_.append(reinterpret_cast<char const*>(values.data()), length);
    }
    if (!std::is_same_v<To, From> || given != stored) {
        for (std::size_t i = 0; i < tuples; ++i)
            for (std::size_t k = 0; k < stored; ++k)
                put(bytes_, k < given ? static_cast<To>(values[i * given + k]) : To{});
    }
    std::string const head =
        fmt::format(R"(<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="appended" offset="{}")",
                    vtk_type<To>(), xml_escaped(name), shown, offset);
    if (unit.empty()) return head + "/>\n";
    return fmt::format(
        "{}><InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{}</InformationKey></DataArray>\n", head,
        xml_escaped(unit));
}

std::string AppendedArrays::add(std::string_view name, std::string_view unit, int components,
                                std::span<float const> values)
{
    return append<float>(name, unit, components, components, values);
}

std::string AppendedArrays::add(std::string_view name, std::string_view unit, int components,
                                std::span<std::int64_t const> values)
{
    return append<std::int64_t>(name, unit, components, components, values);
}

std::string AppendedArrays::add_padded(std::string_view name, std::string_view unit, int components,
                                       std::span<double const> values, Precision precision)
{
    if (precision == Precision::float32) return append<float>(name, unit, components, padded(components), values);
    return append<double>(name, unit, components, padded(components), values);
}

std::string AppendedArrays::add_padded(std::string_view name, std::string_view unit, int components,
                                       std::span<float const> values)
{
    return append<float>(name, unit, components, padded(components), values);
}

std::string AppendedArrays::document(std::string_view type, std::string_view body) const
{
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n{}<AppendedData encoding=\"raw\">\n_",
        type, body);
    text.reserve(text.size() + bytes_.size() + 32);
    text += bytes_;
    text += "\n</AppendedData>\n</VTKFile>\n";
    return text;
}

std::string xml_escaped(std::string_view text)
{
    std::string result;
    for (char const c : text) {
        switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            default:
                result += c;
        }
    }
    return result;
}

}  // namespace sluice
