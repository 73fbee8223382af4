#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstring>
#include <new>

#include "tests/bench/raw.hpp"

namespace bench {
namespace {

constexpr int spins = 20'000;  // pauses of about 50 ns

void pause()
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

//! One direction: a counter that is a futex, and room for one message.
struct Mailbox
{
    alignas(64) std::atomic<std::uint32_t> count;
    alignas(64) std::atomic<std::uint32_t> sleeping;
    alignas(64) std::byte content[1];

    void send(std::span<std::byte const> bytes)
    {
        std::memcpy(content, bytes.data(), bytes.size());
        count.fetch_add(1);
        if (sleeping.load() != 0) ::syscall(SYS_futex, &count, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
    }

    void receive(std::span<std::byte> bytes, std::uint32_t seen)
    {
        for (int i = 0; i < spins && count.load(std::memory_order_acquire) == seen; ++i) pause();
        while (count.load() == seen) {
            sleeping.store(1);
            ::syscall(SYS_futex, &count, FUTEX_WAIT, seen, nullptr, nullptr, 0);
            sleeping.store(0);
        }
        std::memcpy(bytes.data(), content, bytes.size());
    }
};

std::size_t mailbox_size(std::size_t most_points)
{
    return (sizeof(Mailbox) + most_points * point_size + 4095) / 4096 * 4096;
}

class RawShm final : public Way
{
 public:
    explicit RawShm(Setting const& setting)
        : side_(setting.side),
          to_{mailbox(setting, 0), mailbox(setting, 1)},
          field_(setting.most_points),
          copy_(setting.most_points)
    {}

    void round_trip(std::size_t points) override
    {
        if (side_ == 0) to_[1]->send(field_.of(points));
        to_[side_]->receive(copy_.of(points), seen_++);
        if (side_ == 1) to_[0]->send(field_.of(points));
    }

 private:
    static Mailbox* mailbox(Setting const& s, std::size_t to)  // the arena is zero at first
    {
        return std::launder(reinterpret_cast<Mailbox*>(s.arena.data() + to * mailbox_size(s.most_points)));
    }

    int side_;
    Mailbox* to_[2];
    Field field_, copy_;
    std::uint32_t seen_ = 0;
};

}  // namespace

std::size_t raw_shm_size(std::size_t most_points)
{
    return 2 * mailbox_size(most_points);
}

std::unique_ptr<Way> raw_shm(Setting const& setting)
{
    return std::make_unique<RawShm>(setting);
}

}  // namespace bench
