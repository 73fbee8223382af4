#include <condition_variable>
#include <deque>
#include <mutex>

#include "coupler/transport/buffer.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {

struct LoopbackHub::State
{
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::deque<Transport::Incoming>> inbox;  //!< per member
    std::vector<char> left;                              //!< per member
};

namespace {

class LoopbackTransport final : public Transport
{
 public:
    LoopbackTransport(std::shared_ptr<LoopbackHub::State> state, int self) : state_(std::move(state)), self_(self) {}

    ~LoopbackTransport() override
    {
        std::lock_guard const lock(state_->mutex);
        state_->left[static_cast<std::size_t>(self_)] = 1;
        state_->changed.notify_all();
    }

    std::span<std::byte> reserve(int /*peer*/, std::size_t size) override
    {
        if (!next_) next_ = pool_.take();
        return next_->room(size);
    }

    bool commit(int peer, std::size_t size) override
    {
        std::lock_guard const lock(state_->mutex);
        std::span<std::byte const> const bytes(next_->data(), size);
        state_->inbox[static_cast<std::size_t>(peer)].push_back({self_, {bytes, std::move(next_)}});
        state_->changed.notify_all();
        return true;
    }

    std::optional<Incoming> receive(std::chrono::microseconds patience) override
    {
        std::unique_lock lock(state_->mutex);
        auto& inbox = state_->inbox[static_cast<std::size_t>(self_)];
        if (!state_->changed.wait_for(lock, patience, [&] { return !inbox.empty(); })) return std::nullopt;
        auto message = std::move(inbox.front());
        inbox.pop_front();
        return message;
    }

    std::string kind() const override { return "loopback"; }

    bool lost(int peer) const override
    {
        std::lock_guard const lock(state_->mutex);
        return state_->left[static_cast<std::size_t>(peer)] != 0;
    }

 private:
    std::shared_ptr<LoopbackHub::State> state_;
    int self_;
    BufferPool pool_;
    std::shared_ptr<Buffer> next_;
};

}  // namespace

LoopbackHub::LoopbackHub(int members) : state_(std::make_shared<State>())
{
    state_->inbox.resize(static_cast<std::size_t>(members));
    state_->left.resize(static_cast<std::size_t>(members));
}

LoopbackHub::~LoopbackHub() = default;

std::unique_ptr<Transport> LoopbackHub::connect(int self)
{
    return std::make_unique<LoopbackTransport>(state_, self);
}

}  // namespace sluice
