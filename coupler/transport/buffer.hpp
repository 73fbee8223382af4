#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <vector>

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

//! Buffers that are used again. What take() gives comes back by itself, from any thread, also after the pool has gone.
class BufferPool
{
 public:
    //! The buffer that came back last, or a new one.
    std::shared_ptr<Buffer> take()
    {
        std::unique_ptr<Buffer> buffer;
        {
            std::lock_guard const lock(spare_->mutex);
            if (!spare_->buffers.empty()) {
                buffer = std::move(spare_->buffers.back());
                spare_->buffers.pop_back();
            }
        }
        if (!buffer) buffer = std::make_unique<Buffer>();
        return {buffer.release(), [spare = spare_](Buffer* back) { spare->keep(std::unique_ptr<Buffer>(back)); }};
    }

 private:
    struct Spare
    {
        static constexpr std::size_t most = 16;  // more are given back to the system
        std::mutex mutex;
        std::vector<std::unique_ptr<Buffer>> buffers;

        Spare() { buffers.reserve(most); }
        void keep(std::unique_ptr<Buffer> buffer) noexcept
        {
            std::lock_guard const lock(mutex);
            if (buffers.size() < most) buffers.push_back(std::move(buffer));
        }
    };
    std::shared_ptr<Spare> spare_ = std::make_shared<Spare>();
};

}  // namespace sluice
