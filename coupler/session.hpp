#pragma once

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>

#include "coupler/base/name_lock.hpp"
#include "coupler/base/status_page.hpp"
#include "coupler/channel.hpp"
#include "coupler/record/trace.hpp"

namespace sluice {

using Clock = std::chrono::steady_clock;

inline std::chrono::milliseconds in_milliseconds(double s)
{
    return std::chrono::milliseconds(static_cast<std::int64_t>(s * 1000));
}

//! What a participant said about itself at the handshake.
struct Greeting
{
    bool arrived = false;
    std::uint64_t nonce = 0;
    double window = 0;  //!< proposed, s; 0: none
    bool exact = false;
};

//! The length that all proposals allow. Every participant computes the same from the same greetings.
//! Throws Error (exit 2) if nobody proposes one, or if exact ones do not divide the window.
double choose_window(Scene const& scene, std::vector<Greeting> const& greetings);

//! Everything behind a Participant. Order of life: configuration, connect(), windows, leave().
struct Participant::Session
{
    explicit Session(JoinOptions options);

    void connect();                //!< transport, handshake, window length
    bool advance(Window& window);  //!< exchanges until the next window can be computed; false: the run is over
    void leave();                  //!< all have sent everything
    void tell_peers(std::string const& why) noexcept;
    void write_summary(int exit) const;
    Error lost_peer(int peer) const;
    std::string command_of(int participant) const;
    std::string where() const;  //!< "window 12 of 500 (t = 0.34 s)"

    JoinOptions options;
    LoadedScene loaded;
    Scene const& scene;
    int self = -1;
    std::unique_ptr<NameLock> lock;  //!< on the name, in the run's directory
    MappedStatus status;
    std::unique_ptr<Transport> transport;
    std::vector<Greeting> greetings;
    std::vector<char> said_bye;
    std::uint64_t session = 0;
    std::vector<Samples::Source> in;
    std::vector<OutChannel> out;
    std::optional<Schedule> schedule;
    double window_length = 0;
    std::int64_t window_count = 0;
    bool consequence = false;  //!< this one stops because another one did
    bool computing = false;    //!< between two windows the solver has the word
    nlohmann::ordered_json facts = nlohmann::ordered_json::object();
    nlohmann::ordered_json warnings = nlohmann::ordered_json::array();
    nlohmann::ordered_json skipped = nlohmann::ordered_json::array();
    std::int64_t bytes_sent = 0;
    std::unique_ptr<Trace> trace;

 private:
    void send(int peer, std::span<std::byte const> bytes, Clock::time_point deadline);
    bool greet(int peer);  //!< false: no connection yet
    void meet_all();
    void handle(Transport::Incoming const& incoming);
    void handle_greeting(int peer, std::string const& text);
    bool is_preparing(int peer) const;
    void await_credit(OutChannel& channel, std::int64_t frame);
    void send_frames(std::int64_t frame);
    void await_frame(int edge);
    void book(Activity activity);  //!< the time since the last call

    Clock::time_point start_ = Clock::now();
    Clock::time_point mark_ = Clock::now();
};

}  // namespace sluice
