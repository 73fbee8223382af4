#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

//! Plain values and vectors of them to bytes and back, in this machine's byte order.
namespace dem {

class ByteWriter
{
 public:
    template <class T>
    void operator()(T const& value)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        auto const* from = reinterpret_cast<std::byte const*>(&value);
        bytes.insert(bytes.end(), from, from + sizeof value);
    }
    template <class T>
    void operator()(std::vector<T> const& values)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        (*this)(static_cast<std::uint64_t>(values.size()));
        auto const* from = reinterpret_cast<std::byte const*>(values.data());
        bytes.insert(bytes.end(), from, from + values.size() * sizeof(T));
    }

    std::vector<std::byte> bytes;
};

//! Reads what ByteWriter wrote; `ok` turns false, for good, when the bytes do not suffice. Never allocates more than
//! the bytes hold.
class ByteReader
{
 public:
    explicit ByteReader(std::span<std::byte const> bytes) : rest_(bytes) {}

    template <class T>
    void operator()(T& value)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        if (!take(sizeof value)) return;
        std::memcpy(&value, taken_.data(), sizeof value);
    }
    template <class T>
    void operator()(std::vector<T>& values)
    {
        std::uint64_t count = 0;
        (*this)(count);
        if (!ok || count > rest_.size() / sizeof(T)) {
            ok = false;
            return;
        }
        values.resize(static_cast<std::size_t>(count));
        take(values.size() * sizeof(T));
        if (!values.empty()) std::memcpy(values.data(), taken_.data(), taken_.size());
    }
    bool at_end() const { return ok && rest_.empty(); }

    bool ok = true;

 private:
    bool take(std::size_t count)
    {
        ok = ok && count <= rest_.size();
        if (!ok) return false;
        taken_ = rest_.first(count);
        rest_ = rest_.subspan(count);
        return true;
    }
    std::span<std::byte const> rest_, taken_;
};

}  // namespace dem
