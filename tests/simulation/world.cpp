#include "tests/simulation/world.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace simulation {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t most_steps = 400'000;  // a course that needs more goes round in circles
constexpr std::int64_t notice = 30'000;       // microseconds until the end of a process is seen by others, at most

}  // namespace

class VirtualTransport final : public Transport
{
 public:
    VirtualTransport(World& world, int self) : world_(world), self_(self) { world.connect(self); }
    ~VirtualTransport() override { world_.leave(self_); }

    std::span<std::byte> reserve(int /*peer*/, std::size_t size) override
    {
        if (!next_) next_ = world_.pool_.take();
        return next_->room(size);
    }
    bool commit(int peer, std::size_t size) override
    {
        world_.dawdle(self_);
        if (!world_.commit(self_, peer, {next_->data(), size}, next_)) return false;
        next_.reset();
        return true;
    }
    std::optional<Incoming> receive(microseconds patience) override
    {
        world_.dawdle(self_);
        return world_.receive(self_, patience);
    }
    bool lost(int peer) const override { return world_.lost(self_, peer); }
    std::string trouble(int peer) const override
    {
        return world_.line(peer, self_).vanished && lost(peer) ? "no sign of life for 0.5 s" : "";
    }
    void settle() override { world_.settle(self_); }
    std::string kind() const override { return "virtual"; }
    Clock::time_point now() const override { return world_.now_; }

 private:
    World& world_;
    int self_;
    std::shared_ptr<sluice::Buffer> next_;
};

char const* to_text(Fault fault)
{
    static constexpr char const* texts[] = {"vanish",       "loss",           "twice",       "swap",  "damage",
                                            "crash_sender", "crash_receiver", "host_sender", "pause", "cut",
                                            "isolate",      "reset",          "restart"};
    static_assert(std::size(texts) == static_cast<std::size_t>(Fault::count));
    return texts[static_cast<std::size_t>(fault)];
}

World::World(Fibers& fibers, std::uint64_t seed, int members, Conditions conditions, Body body)
    : fibers_(fibers),
      random_(seed),
      conditions_(std::move(conditions)),
      body_(std::move(body)),
      people_(at(members)),
      lines_(at(members) * at(members))
{
    while (fibers_.size() < people_.size()) fibers_.push_back(std::make_unique<Fiber>());
    for (int m = 0; m < count(); ++m) live(m);
}

World::~World()
{
    for (int m = 0; m < count(); ++m) {
        people_[at(m)].again = false;
        kill(m);
        for (current_ = m; !fibers_[at(m)]->ended();) fibers_[at(m)]->resume();
    }
}

void World::live(int member)
{
    people_[at(member)] = {.wake = soon(conditions_.delay)};
    fibers_[at(member)]->start([this, member] {
        try {
            if (people_[at(member)].doomed) throw Crash{};
            body_(member, std::make_unique<VirtualTransport>(*this, member));
        } catch (Crash const&) {
        }
    });
}

bool World::run(milliseconds longest)
{
    auto const end = now_ + longest;
    for (std::int64_t step = 0; step < most_steps; ++step) {
        int next = -1;
        Time when = Time::max();
        std::int64_t alike = 0;
        for (int m = 0; m < count(); ++m) {
            if (fibers_[at(m)]->ended()) continue;
            auto const t = wake_time(m);
            alike = t < when ? 1 : t == when ? alike + 1 : alike;
            if (t < when || (t == when && random_.one_in(alike))) next = m, when = t;
        }
        if (next < 0) return true;
        now_ = std::max(now_, when);
        if (now_ > end) return false;
        current_ = next;
        fibers_[at(next)]->resume();
        current_ = -1;
        if (fibers_[at(next)]->ended() && people_[at(next)].again) {
            live(next);
            people_[at(next)].wake = soon(200'000);
        }
    }
    return false;
}

Time World::wake_time(int member) const
{
    auto const& person = people_[at(member)];
    if (!person.reads) return person.wake;
    int const from = next_mail(member);
    return from < 0 ? person.wake : std::min(person.wake, line(from, member).mail.front().due);
}

int World::next_mail(int member) const
{
    int from = -1;
    for (int m = 0; m < count(); ++m) {
        auto const& mail = line(m, member).mail;
        if (!mail.empty() && (from < 0 || mail.front().due < line(from, member).mail.front().due)) from = m;
    }
    return from;
}

void World::wait(int member, Time until, bool reads)
{
    auto& person = people_[at(member)];
    person.wake = until;
    person.reads = reads;
    if (!person.doomed) fibers_[at(member)]->pause();
    person.reads = false;
    if (std::exchange(person.doomed, false)) throw Crash{};
}

void World::work(int member, std::int64_t most)
{
    wait(member, soon(most), false);
}

void World::dawdle(int member)
{
    if (conditions_.nap > 0 && random_.one_in(6)) work(member, conditions_.nap);
}

void World::connect(int member)
{
    people_[at(member)].connected = true;
    for (int m = 0; m < count(); ++m) {
        if (m == member) continue;
        auto const& peer = people_[at(m)];
        bool const gone = fibers_[at(m)]->ended() && !peer.again;
        bool const known = line(member, m).lost_from != Time::max();  // we were there before
        bool const refused = known && (peer.settled || gone);
        line(m, member) = Line{.closed = false};
        if (known && !refused) line(member, m) = Line{};
        line(member, m).closed = refused;
        if (gone) line(m, member).lost_from = now_;
    }
}

void World::leave(int member)
{
    people_[at(member)].connected = people_[at(member)].settled = false;
    for (int m = 0; m < count(); ++m) {
        if (m == member) continue;
        auto& way = line(member, m);
        way.lost_from = std::min(way.lost_from, std::max(now_, way.last) + microseconds(random_.below(notice)));
        way.lost_until = Time::max();
        auto& back = line(m, member);
        back.mail.clear();
        (conditions_.refuses_dead ? back.closed : back.swallows) = true;
    }
}

void World::settle(int member)
{
    people_[at(member)].settled = true;
    for (int m = 0; m < count(); ++m)
        if (m != member && lost(member, m)) sever(member, m, now_, Time::max());
}

bool World::lost(int member, int peer) const
{
    auto const& way = line(peer, member);
    if (way.vanished && now_ - way.quiet_since > silence) return true;
    return now_ >= way.lost_from && now_ < way.lost_until;
}

std::optional<Transport::Incoming> World::receive(int member, microseconds patience)
{
    auto const deadline = now_ + patience;
    for (;;) {
        int const from = next_mail(member);
        if (from >= 0 && line(from, member).mail.front().due <= now_) {
            auto& way = line(from, member);
            Transport::Incoming incoming{from, std::move(way.mail.front().message)};
            way.mail.pop_front();
            way.quiet_since = now_;
            return incoming;
        }
        if (now_ >= deadline) return std::nullopt;
        wait(member, deadline, true);
    }
}

void World::deliver(Line& way, Time due, std::span<std::byte const> bytes, std::shared_ptr<void const> owner)
{
    auto const later =
        std::upper_bound(way.mail.begin(), way.mail.end(), due, [](Time t, Mail const& mail) { return t < mail.due; });
    way.mail.insert(later, {due, {bytes, std::move(owner)}});
}

bool World::commit(int from, int to, std::span<std::byte const> bytes, std::shared_ptr<void const> owner)
{
    auto& way = line(from, to);
    bool const reachable = people_[at(to)].connected || way.swallows;
    if (!reachable || way.closed || way.mail.size() >= conditions_.capacity || lost(from, to)) return false;
    auto const number = messages_++;
    for (auto const& strike_here : conditions_.strikes)
        if (strike_here.message == number) {
            ++struck_;
            if (strike(strike_here.fault, from, to, bytes)) return true;
        }
    if (way.swallows) return true;
    way.last = std::max({way.last, way.not_before, soon(conditions_.delay)});
    deliver(way, way.last, bytes, std::move(owner));
    return true;
}

//! True: the message has been dealt with.
bool World::strike(Fault fault, int from, int to, std::span<std::byte const> bytes)
{
    auto& way = line(from, to);
    auto const copy = [&] {
        auto buffer = pool_.take();
        std::memcpy(buffer->room(bytes.size()).data(), bytes.data(), bytes.size());
        return buffer;
    };
    switch (fault) {
        case Fault::vanish:
            way.vanished = true;
            way.quiet_since = now_;
            return true;
        case Fault::loss: {
            sever(from, to, soon(notice), Time::max());
            return true;
        }
        case Fault::twice: {
            auto const again = copy();
            way.last = std::max({way.last, way.not_before, soon(conditions_.delay)});
            deliver(way, way.last + microseconds(random_.below(notice)), {again->data(), bytes.size()}, again);
            return false;
        }
        case Fault::swap: {
            auto const kept = copy();
            deliver(way, std::max(way.last, soon(conditions_.delay)) + microseconds(random_.below(4 * notice)),
                    {kept->data(), bytes.size()}, kept);
            return true;
        }
        case Fault::damage: {
            auto const changed = copy();
            bool const head = random_.one_in(2) || bytes.size() <= 64;
            auto const room = static_cast<std::int64_t>(bytes.size());
            auto const where = static_cast<std::size_t>(head ? random_.below(std::min<std::int64_t>(64, room))
                                                             : 64 + random_.below(room - 64));
            changed->data()[where] ^= static_cast<std::byte>(1u << random_.below(8));
            way.last = std::max({way.last, way.not_before, soon(conditions_.delay)});
            deliver(way, way.last, {changed->data(), bytes.size()}, changed);
            return true;
        }
        case Fault::crash_receiver:
            kill(to);
            return false;
        case Fault::crash_sender:
            kill(from);
            return true;
        case Fault::host_sender:
            for (int m = 0; m < count(); ++m)
                if (m != from) isolate(from, m, now_ + silence);
            kill(from);
            return true;
        case Fault::pause:
            for (Line* each : {&way, &line(to, from)}) {
                each->not_before = now_ + microseconds(random_.below(400'000));
                for (auto& mail : each->mail) mail.due = std::max(mail.due, each->not_before);
                each->last = std::max(each->last, each->not_before);
            }
            return false;
        case Fault::cut:
            isolate(from, to, now_ + silence);
            return true;
        case Fault::isolate:
            for (int m = 0; m < count(); ++m)
                if (m != from) isolate(from, m, now_ + silence);
            return true;
        case Fault::reset: {
            bool const meeting = !people_[at(from)].settled && !people_[at(to)].settled;
            for (Line* each : {&way, &line(to, from)}) each->mail.clear();
            sever(from, to, now_, meeting ? now_ + microseconds(random_.between(1'000, 50'000)) : Time::max());
            return true;
        }
        case Fault::restart:
            people_[at(from)].again = true;
            kill(from);
            return true;
        case Fault::count:
            break;
    }
    return false;
}

//! A process dies: at once if it is the one that runs, else when it would have run next.
void World::kill(int member)
{
    auto& person = people_[at(member)];
    if (fibers_[at(member)]->ended()) {
        person.again = false;
        return;
    }
    person.crashed = person.doomed = true;
    person.wake = now_;
    if (member != current_ || !person.connected) return;
    person.doomed = false;
    throw Crash{};
}

void World::sever(int a, int b, Time from, Time until)
{
    for (Line* way : {&line(a, b), &line(b, a)}) {
        way->lost_from = std::min(way->lost_from, from);
        way->lost_until = until;
    }
}

//! Nothing goes either way from now on, and both find it out later.
void World::isolate(int a, int b, Time from)
{
    for (Line* way : {&line(a, b), &line(b, a)}) {
        way->mail.clear();
        way->swallows = true;
    }
    sever(a, b, from, Time::max());
}

}  // namespace simulation
