#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "coupler/transport/transport.hpp"

namespace sluice {

//! What the events of one socket say about the connection with its peer: a state machine, fed by ConnectionWatch.
//! Strangers connect to a listener as well; theirs never become the peer's own.
class Connection
{
 public:
    struct Terms
    {
        bool listener = false;
        bool tcp = false;
        bool curve = false;
        std::chrono::milliseconds silence{0};
    };
    explicit Connection(Terms const& terms) : terms_(terms) {}

    void event(int number, int value);     //!< ZMQ_EVENT_...; value: a descriptor, an error or a status, see zmq.h
    void carried_message(int descriptor);  //!< a message came over this connection, so it is the peer's own
    void refused(std::string const& why);  //!< by this side's doorman
    void look();  //!< whether the peer is silent for too long; call a few times in the silence allowed
    void settle();

    bool lost() const { return lost_; }
    bool is_taken() const { return own_ >= 0; }
    //! What is sent now goes somewhere: events come from another thread, and may be later than the peer's first
    //! message.
    bool is_open() const { return is_taken() || early_ >= 0; }
    bool is_settled() const { return settled_; }
    //! Whether an attempt to connect has ended since the last call: it is to be repeated. Each ends once.
    bool take_failed_attempt() { return std::exchange(failed_attempt_, false); }
    //! Nobody answered this side's last attempt to connect.
    bool unreached() const { return !reached_ && !terms_.listener; }
    int listening() const { return listening_; }  //!< descriptor of the listening socket, or -1
    //! Empty: nothing is known.
    std::string trouble() const;

 private:
    using Clock = Transport::Clock;
    void opened(int descriptor);
    void closed(int descriptor);
    void make_own(int descriptor);
    void hang_up_on_silent();
    bool latched() const;
    std::string how_it_ended() const;
    std::string handshake_trouble(int number, int value) const;
    void note_handshake(int number, int value);

    Terms terms_;
    struct Other  //!< the other end of a connection
    {
        pid_t process = 0;         //!< where the kernel tells (ipc)
        std::uint64_t cookie = 0;  //!< the kernel's name of the socket: descriptors are used again
    };
    std::map<int, Other> open_;  //!< connections there are, by descriptor
    std::set<int> gone_;         //!< descriptors that were closed and not used again
    int own_ = -1;               //!< the peer's own connection
    int early_ = -1;             //!< one that carried a message before its beginning was known
    Other other_;                //!< of the peer's own connection
    int listening_ = -1;
    bool lost_ = false, silent_ = false, settled_ = false, failed_attempt_ = false, reached_ = false;
    Clock::time_point settled_at_{}, heard_{};
    std::string handshake_, refusal_;
    int turned_away_ = 0;
};

}  // namespace sluice
