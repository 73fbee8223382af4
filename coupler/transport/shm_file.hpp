#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace sluice {

//! A part of a SharedFile in this process's address space.
class Mapping
{
 public:
    Mapping() = default;
    Mapping(std::byte* data, std::size_t size) : data_(data), size_(size) {}
    Mapping(Mapping&& other) noexcept : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0))
    {}
    Mapping& operator=(Mapping&& other) noexcept
    {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        return *this;
    }
    ~Mapping();
    std::byte* data() const { return data_; }
    std::size_t size() const { return size_; }

 private:
    std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

//! Memory without a name (memfd), shared with processes of the same user on this host: it is gone when the last of them
//! is, however that ends. It can never shrink, so what lies within its size can be read without a SIGBUS.
class SharedFile
{
 public:
    //! Where another process finds it: /proc/PID/fd/DESCRIPTOR.
    struct Address
    {
        int process = 0;
        int descriptor = -1;
    };
    enum class Access
    {
        read,
        write
    };

    //! Of `size` bytes, all zero and not yet backed by memory. Throws Error (exit 7).
    static SharedFile create(std::size_t size);
    //! That of another process; nothing if it cannot be reached (another host, another user), is not such a file, or is
    //! smaller than `size`.
    static std::optional<SharedFile> open(Address address, std::size_t size);

    SharedFile(SharedFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    SharedFile& operator=(SharedFile&& other) noexcept
    {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    ~SharedFile();

    Address address() const;
    //! Backs a range with memory. Throws Error (exit 7) if there is none, where a later access would end the process.
    void allocate(std::size_t offset, std::size_t size) const;
    //! `offset` is a multiple of the page size. Throws Error (exit 7).
    Mapping map(std::size_t offset, std::size_t size, Access access) const;

 private:
    explicit SharedFile(int descriptor) : descriptor_(descriptor) {}
    int descriptor_ = -1;
};

}  // namespace sluice
