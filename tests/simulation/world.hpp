#pragma once

#include <deque>
#include <map>
#include <vector>

#include "coupler/transport/buffer.hpp"
#include "coupler/transport/transport.hpp"
#include "tests/simulation/fibers.hpp"
#include "tests/simulation/random.hpp"

namespace simulation {

using sluice::Transport;
using Clock = Transport::Clock;
using Time = Clock::time_point;
using std::chrono::microseconds;

//! What happens to the message of a given number, or to those at its ends.
enum class Fault
{
    vanish,          //!< it is gone, and the transport does not know
    loss,            //!< it is gone, and from then on both ends find each other lost
    twice,           //!< it comes again a little later
    swap,            //!< it comes after those that were sent later
    damage,          //!< one bit of it is another
    crash_sender,    //!< its process dies instead of sending it
    crash_receiver,  //!< the process that it is for dies
    host_sender,     //!< the sender's whole host is gone: also what is under way; found by silence
    pause,           //!< the pair is cut for less than a silence that counts
    cut,             //!< the pair is cut for good: found by silence
    isolate,         //!< the sender is cut from everybody for good
    reset,           //!< the connection breaks; while people still meet it comes back
    restart,         //!< the sender's process dies and is started again
    count
};
char const* to_text(Fault fault);

struct Strike
{
    std::int64_t message;  //!< in the order in which they are sent, from 0
    Fault fault;
};

//! What the world is like in one schedule; all times in microseconds.
struct Conditions
{
    std::int64_t delay = 100;   //!< of a message, at most
    std::int64_t nap = 0;       //!< that a member may be kept from running, now and then, at most
    std::size_t capacity = 64;  //!< messages under way or unread for each pair and way
    bool refuses_dead = false;  //!< whether a send to one that ended fails, or disappears
    std::vector<Strike> strikes = {};
};

//! Thrown out of a member's transport when its process dies.
struct Crash
{};

using Fibers = std::vector<std::unique_ptr<Fiber>>;

//! Members in fibers, a clock that jumps from event to event, and the network between them. One seed, one course.
class World
{
 public:
    using Body = std::function<void(int member, std::unique_ptr<Transport>)>;
    World(Fibers& fibers, std::uint64_t seed, int members, Conditions conditions, Body body);
    ~World();

    //! Until all members have ended. False: they did not within `longest` of virtual time.
    bool run(std::chrono::milliseconds longest);
    void work(int member, std::int64_t most);  //!< takes up to so many microseconds of virtual time

    bool crashed(int member) const { return people_[at(member)].crashed; }
    std::int64_t messages() const { return messages_; }
    std::int64_t struck() const { return struck_; }
    Time now() const { return now_; }

    static constexpr std::chrono::milliseconds silence{500};

 private:
    friend class VirtualTransport;
    struct Mail
    {
        Time due;
        sluice::Message message;
    };
    struct Line  //!< from one member to another
    {
        std::deque<Mail> mail = {};                              //!< by when it comes
        Time last = {};                                          //!< when the newest comes
        Time not_before = {};                                    //!< what is sent now comes no earlier
        Time lost_from = Time::max(), lost_until = Time::max();  //!< the receiver finds the sender lost
        Time quiet_since = {};
        bool vanished = false;  //!< a message is gone without a word: silence counts
        bool closed = false;    //!< takes nothing
        bool swallows = false;  //!< takes everything, and nothing comes
    };
    struct Person
    {
        Time wake = {};
        bool reads = false;  //!< it waits for mail, too
        bool connected = false, settled = false, doomed = false, crashed = false;
        bool again = false;  //!< it is started again
    };

    static std::size_t at(int member) { return static_cast<std::size_t>(member); }
    Line& line(int from, int to) { return lines_[at(from) * people_.size() + at(to)]; }
    Line const& line(int from, int to) const { return lines_[at(from) * people_.size() + at(to)]; }
    Time soon(std::int64_t most) { return now_ + microseconds(random_.below(most + 1)); }
    int count() const { return static_cast<int>(people_.size()); }

    void live(int member);
    void connect(int member);
    void leave(int member);
    void settle(int member);
    bool commit(int from, int to, std::span<std::byte const> bytes, std::shared_ptr<void const> owner);
    std::optional<Transport::Incoming> receive(int member, microseconds patience);
    bool lost(int member, int peer) const;

    void wait(int member, Time until, bool reads);
    void dawdle(int member);
    int next_mail(int member) const;  //!< whose comes first; -1: nobody's
    Time wake_time(int member) const;
    void deliver(Line& way, Time due, std::span<std::byte const> bytes, std::shared_ptr<void const> owner);
    bool strike(Fault fault, int from, int to, std::span<std::byte const> bytes);
    void kill(int member);
    void sever(int a, int b, Time from, Time until);
    void isolate(int a, int b, Time from);

    Fibers& fibers_;
    Random random_;
    Conditions conditions_;
    Body body_;
    std::vector<Person> people_;
    std::vector<Line> lines_;
    sluice::BufferPool pool_;
    Time now_{std::chrono::hours(1)};
    std::int64_t messages_ = 0, struck_ = 0;
    int current_ = -1;
};

}  // namespace simulation
