#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <span>

#include "coupler/transport/transport.hpp"

namespace sluice {

//! Memory for one message, aligned to 64 bytes, not initialised; it grows and never shrinks.
class Buffer
{
 public:
    std::span<std::byte> room(std::size_t size)
    {
        if (size > capacity_ || !memory_) {
            std::size_t const wanted = size < 64 ? 64 : size + size / 4;
            memory_.reset(static_cast<std::byte*>(::operator new (wanted, std::align_val_t{64})));
            capacity_ = wanted;
        }
        return {memory_.get(), size};
    }
    std::byte* data() const { return memory_.get(); }

 private:
    struct Free
    {
        void operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{64}); }
    };
    std::unique_ptr<std::byte, Free> memory_;
    std::size_t capacity_ = 0;
};

}  // namespace sluice
