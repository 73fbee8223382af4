#include <doctest/doctest.h>

#include <cstring>
#include <memory>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "coupler/transport/shm_bell.hpp"
#include "coupler/transport/shm_ring.hpp"

namespace {

using sluice::Bell;
using sluice::Ring;
using sluice::RingReceiver;
using sluice::RingSender;
using std::chrono::seconds;

//! A ring, a bell and slots in plain memory, so that a thread sanitizer sees both sides.
struct Shared
{
    Ring ring{};
    Bell bell{};
    std::array<std::array<std::uint64_t, 8>, Ring::slots> slots{};
};

//! Now and then, so that each side finds the other one asleep, awake, and in between.
class Naps
{
 public:
    explicit Naps(unsigned seed) : random_(seed) {}
    void maybe()
    {
        auto const n = random_() % 64;
        if (n == 0) std::this_thread::sleep_for(std::chrono::microseconds(random_() % 300));
        if (n < 4) std::this_thread::yield();
    }

 private:
    std::minstd_rand random_;
};

}  // namespace

TEST_CASE("ring: no message and no wake-up is lost, whoever naps, and slots are written by one side at a time")
{
    constexpr std::uint64_t messages = 20'000;
    auto shared = std::make_unique<Shared>();
    std::thread sender([&] {
        RingSender out(shared->ring);
        Naps naps(1);
        for (std::uint64_t n = 0; n < messages;) {
            auto const slot = out.take();
            if (!slot) {
                std::this_thread::yield();
                continue;
            }
            shared->slots[static_cast<std::size_t>(*slot)].fill(n);
            naps.maybe();
            out.publish(*slot, n++);
            if (shared->bell.ring_is_for_network()) FAIL_CHECK("nobody sleeps in a network");
        }
    });
    RingReceiver in(shared->ring);
    Naps naps(2);
    std::vector<RingReceiver::Descriptor> kept;
    std::uint64_t wrong = 0, lost_wakeups = 0;
    for (std::uint64_t n = 0; n < messages;) {
        auto const next = in.take();
        if (!next) {
            shared->bell.announce(Bell::on_bell);
            if (in.ready()) {
                shared->bell.stay_awake();
                continue;
            }
            auto const begin = std::chrono::steady_clock::now();
            shared->bell.sleep(seconds(20));
            lost_wakeups += std::chrono::steady_clock::now() - begin >= seconds(20);
            continue;
        }
        wrong += next->size != n;
        for (auto const word : shared->slots[next->slot]) wrong += word != n;
        ++n;
        naps.maybe();
        kept.push_back(*next);
        if (kept.size() > 5) {  // out of order
            in.give_back(static_cast<int>(kept[n % 5].slot));
            kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(n % 5));
        }
    }
    sender.join();
    CHECK(wrong == 0);
    CHECK(lost_wakeups == 0);
}

TEST_CASE("ring: a sender has as many slots as there are, and takes the one that came back last")
{
    auto ring = std::make_unique<Ring>();
    RingSender out(*ring);
    RingReceiver in(*ring);
    for (int n = 0; n < Ring::slots; ++n) out.publish(out.take().value(), 0);
    CHECK_FALSE(out.take());
    std::vector<int> slots;
    while (auto const next = in.take()) slots.push_back(static_cast<int>(next->slot));
    REQUIRE(slots.size() == Ring::slots);
    CHECK_FALSE(out.take());
    in.give_back(slots[4]);
    in.give_back(slots[4]);  // a mistake that does no harm
    CHECK(out.take() == slots[4]);
    CHECK_FALSE(out.take());
    out.put_back(slots[4]);
    in.give_back(slots[9]);
    CHECK(out.take() == slots[9]);
    CHECK(out.take() == slots[4]);
    CHECK_FALSE(out.take());
}

TEST_CASE("ring: a sender stays in its bounds whatever comes back")
{
    auto ring = std::make_unique<Ring>();
    RingSender out(*ring);
    std::minstd_rand random(3);
    std::multiset<int> away;
    for (int n = 0; n < 100'000; ++n) {
        if (n % 3 == 0) ring->returned.fetch_or(random() * std::uint64_t{77'777'777'777});
        auto const slot = out.take();
        if (!slot) continue;
        REQUIRE(*slot >= 0);
        REQUIRE(*slot < Ring::slots);
        if (n % 7 == 0)
            out.put_back(*slot);
        else
            out.publish(*slot, 1);
    }
}
