#pragma once

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>

#include "coupler/base/name_lock.hpp"
#include "coupler/base/status_page.hpp"
#include "coupler/base/ticks.hpp"
#include "coupler/channel.hpp"
#include "coupler/group_part.hpp"
#include "coupler/record/checkpoint.hpp"
#include "coupler/record/recording.hpp"
#include "coupler/record/trace.hpp"

namespace sluice {

using Clock = std::chrono::steady_clock;

inline std::chrono::milliseconds in_milliseconds(double s)
{
    return std::chrono::milliseconds(static_cast<std::int64_t>(s * 1000));
}

//! One process of the run, as the transport numbers them: by participant, then by rank.
struct Member
{
    int participant = 0;
    int rank = 0;
};
std::vector<Member> members_of(Scene const& scene);
//! "grains", or "water:1" where a participant has several processes. Names its status page and its checkpoint part.
std::string name_of(Scene const& scene, Member const& member);
//! "grains -> water: kinematics": names its books.
std::string name_of(Scene const& scene, Edge const& edge);
//! Of a life: another number each time.
std::uint64_t new_nonce();

//! What a process said about itself at the handshake.
struct Greeting
{
    std::uint64_t nonce = 0;  //!< of its life: another one each time it begins to meet the others; 0: it has not come
    bool knows_us = false;    //!< it has read our greeting
    int process = 0;          //!< its id, on its host
    double window = 0;        //!< proposed, s; 0: none
    bool exact = false;
    bool can_store = false;                     //!< its solver keeps its state
    std::int64_t resumes = -1;                  //!< window of the checkpoint that it goes on from; -1: none
    std::optional<Box> box = {};                //!< the part of space that it covers
    std::map<int, std::uint32_t> columns = {};  //!< per in-edge that does not read all of them: which
};

//! The length that all proposals allow. Every process computes the same from the same greetings.
//! Throws Error (exit 2) if nobody proposes one, or if exact ones do not divide the window.
double choose_window(Scene const& scene, std::vector<Greeting> const& greetings);

//! The first line in which two texts of `path = value` lines differ, as both sides have it.
std::string difference(std::string const& here, std::string const& there);

//! Begins MPI if the run will use it: MPI's own beginning waits for all and does not rest, a solver that prepares for
//! long would keep the others busy.
void begin_mpi_early(Scene const& scene);

//! When windows begin and end. The process that paces the run decides, the others are told.
struct Pace
{
    Timescale scale;
    std::int64_t end = 0;                     //!< ticks; the last window ends here, or behind it where steps are exact
    std::int64_t grain = 1;                   //!< ticks; every window is a multiple
    std::int64_t length = ticks_per_window;   //!< of the next window
    bool exact = false;                       //!< no window may be cut short
    std::string why_over = {};                //!< not empty: the solver ends the run with the next window
    std::int32_t requests = 0;                //!< bits of Request
    Clock::time_point stored = Clock::now();  //!< when the last checkpoint was taken
    std::int64_t stored_window = 0;
};

//! "Edge" of a recording's first record: the length of the first window [s] as a double.
inline constexpr std::uint32_t recorded_window = 0xffff'fff0;

//! What a signal asked of this process since the last call: bits of Request.
std::int32_t asked_by_signal();

//! Everything behind a Participant. Order of life: configuration, connect(), windows, leave().
//! With on-death: restart a process that loses a peer goes back: it meets all again, and then goes on from the newest
//! checkpoint (rollback.cpp).
struct Participant::Session
{
    //! Thrown where a peer is found dead, caught where the solver calls: it is advance() that goes back.
    struct RollBack
    {
        Error why;
    };

    explicit Session(JoinOptions options);

    void connect();                //!< transport, handshake, window length, the state that is resumed
    bool advance(Window& window);  //!< exchanges until the next window can be computed; false: the run is over
    bool settle();                 //!< after the solver's last write: true: the window stands
    void write(OutChannel& channel, std::span<std::int64_t const> ids,
               std::vector<std::span<double const>> const& columns);
    void set_next_window(double seconds);
    void end_run(std::string const& why);
    void leave();  //!< all have sent everything
    void tell_peers(std::string const& why) noexcept;
    void write_summary(int exit) const;
    Error lost_peer(int member) const;
    std::string command_of(int member) const;
    std::string where() const;  //!< "window 12 of 500 (t = 0.34 s)"
    Problem unasked_rotation() const;
    std::string const& name_of_member(int member) const { return names[static_cast<std::size_t>(member)]; }
    Greeting& mine() { return greetings[static_cast<std::size_t>(self)]; }
    bool paces() const { return self == pacer; }
    //! What deadlines are kept by; times for the report come from Clock itself.
    Clock::time_point now() const { return transport ? transport->now() : Clock::now(); }

    JoinOptions options;
    LoadedScene loaded;
    Scene const& scene;
    std::vector<Member> members;
    std::vector<std::string> names;  //!< of members
    int participant = -1;            //!< which of the scene's this process belongs to
    int self = -1;                   //!< which member it is
    int pacer = 0;                   //!< which member paces the run
    ImplicitGroup const* group = nullptr;
    std::unique_ptr<NameLock> lock;  //!< on the name, in the run's directory
    MappedStatus status;
    std::unique_ptr<Transport> transport;
    std::vector<Greeting> greetings;  //!< per member
    std::vector<char> said_bye;       //!< per member
    std::uint64_t session = 0;
    std::vector<Samples::Source> in;
    std::vector<OutChannel> out;
    std::optional<Schedule> schedule;
    std::map<int, std::uint32_t> reads;  //!< per in-edge: the columns that the solver reads
    std::function<void(State&)> save;
    std::function<void(State const&)> restore;
    Pace pace;
    double window_length = 0;  //!< of the first window, s
    double resumed_at = 0;     //!< s
    bool went_back = false;    //!< and the solver was not told yet
    bool consequence = false;  //!< this one stops because another one did
    bool computing = false;    //!< between two windows the solver has the word
    bool stopped = false;      //!< with a checkpoint, before the end
    nlohmann::ordered_json facts = nlohmann::ordered_json::object();
    nlohmann::ordered_json warnings = nlohmann::ordered_json::array();
    nlohmann::ordered_json skipped = nlohmann::ordered_json::array();
    std::int64_t bytes_sent = 0;
    std::unique_ptr<Trace> trace;
    std::unique_ptr<Recording> recording;

 private:
    void wait_for(int member,
                  std::function<bool()> const& done);  //!< takes in messages until done(); a peer that is lost ends it
    void look_for_lost(std::vector<char>& before);
    void send(int member, std::span<std::byte const> bytes, Clock::time_point deadline);
    std::span<std::byte> room_for(int member, std::size_t size);
    void commit(int member, std::size_t size);
    void stalled(int member, Clock::time_point deadline);
    void broadcast(std::span<std::byte const> bytes);

    void write_now(OutChannel& channel, std::span<std::int64_t const> ids,
                   std::vector<std::span<double const>> const& columns);
    bool advance_once(Window& window);
    bool settle_now();
    void say_goodbye();

    bool may_go_back() const;
    void look_for_newcomers();
    [[noreturn]] void stop_because(Error const& why);  //!< of a peer's end: throws RollBack if this one may go back
    void go_back(Error const& why);
    void forget_session();

    void join();             //!< meets all; then the session, the channels and the state are agreed
    void greet(int member);  //!< unless it has been told all there is to tell, or there is no connection yet
    void meet_all();
    std::pair<std::string, std::string> absent(std::vector<int> const& who) const;
    void handle_greeting(int member, std::string const& text);
    bool is_busy(int member) const;
    void take_early();
    void answer_late_greetings();
    bool is_done(int member) const;

    void handle(Transport::Incoming const& incoming);
    void open_channels();
    void await_credit(OutChannel& channel, OutChannel::Target& target, std::int64_t frame);
    void emit(OutChannel& channel, std::int64_t frame, std::uint32_t iteration, std::span<std::int64_t const> ids,
              std::vector<std::span<double const>> const& columns);
    void book_sent(OutChannel& channel, std::vector<std::span<double const>> const& columns,
                   std::vector<int> const& went);
    void record(OutChannel const& channel, Outgoing const& frame);
    void emit_kept(std::int64_t frame);
    void require_written(std::int64_t frame) const;
    void await_frame(Action const& action);
    void end_computing();

    void start_pace();
    void require_pace(char const* what) const;
    void plan_window(std::int64_t window);
    bool is_stored_by_count(std::int64_t window) const;
    Plan next_plan(std::int64_t window);
    void keep_config();
    void take_plan(int member, Header const& header);
    void look_for_requests();
    void take_request(std::int32_t bits);
    bool all_can_store() const;
    void store(std::int64_t window);
    void take_report(int member, std::int64_t window, std::string const& line);
    void finish_checkpoint();
    State state_before(std::int64_t window) const;
    void find_checkpoint();
    void load_newest();
    void agree_on_checkpoint();
    void resume();

    void take_frame(Samples::Source& channel, Action const& action);
    void begin_group_window();
    bool agree(std::int64_t window, std::uint32_t iteration);  //!< true: the window stands
    void take_verdict(int member, Header const& header, std::vector<double> numbers);
    void open_group();
    void hear_group(std::int64_t window, std::uint32_t iteration);

    void open_accounts();
    void close_accounts();
    void check_account(Account const& account);
    void flag(std::string const& text, bool& warned);  //!< what does not close: stops the run, or is warned of once

    void open_work();
    void look_at(std::int64_t window);
    void keep_for_work(OutChannel& channel, Outgoing const& frame);
    void say_power(OutChannel& channel, int member, Outgoing const& frame);
    void hear_power(int member, Header const& header, std::span<double const> numbers);
    void take_power(Samples::Source& channel, Action const& action);
    void close_work(Samples::Source& channel, double length);
    bool unread(Samples::Source const& channel, std::size_t column) const;
    void open_window(Window& window, Action const& action);
    void book(Activity activity);  //!< the time since the last call

    //! Per member: which of its lives our last greeting answered, as its nonce; 0: none yet; nothing: not greeted.
    std::vector<std::optional<std::uint64_t>> answered_;
    std::deque<Transport::Incoming> early_;  //!< came before the session was agreed
    std::optional<Error> going_back_;        //!< why; the solver has yet to call advance()
    bool leaving_ = false;                   //!< the solver has left its loop
    bool said_goodbye_ = false;
    bool const may_reconnect_;  //!< the transport is of its own making
    int rollbacks_ = 0;
    Clock::time_point newcomers_looked_for_ = Clock::now();
    bool ledger_warned_ = false, energy_warned_ = false, staggering_warned_ = false;
    std::vector<int> late_greetings_;
    Plan plan_;
    std::deque<Plan> told_;          //!< by the one who paces, not used yet
    std::int64_t next_planned_ = 0;  //!< window that the next plan to come is for
    std::int64_t next_begin_ = 0;    //!< and where it begins, ticks
    std::int64_t begin_ = 0;         //!< of the window to be planned, ticks
    std::unique_ptr<CheckpointStore> store_;
    std::optional<Manifest> pending_;  //!< the checkpoint that is being written: parts that have been reported
    std::vector<std::pair<int, std::string>> early_reports_;
    std::optional<State> resumed_;      //!< what this process stored
    std::optional<Plan> resumed_plan_;  //!< of the window that the checkpoint was taken before
    std::vector<std::int64_t> waited_;  //!< per participant, ns
    std::int64_t iterations_ = 0, unconverged_ = 0;
    std::optional<State> resumed_group_;

    //! In an implicit group: the solver's state before the window, what this process holds, what the others said.
    struct Said
    {
        std::int64_t window;
        std::uint32_t iteration;
        std::vector<double> numbers;
    };
    State before_;
    std::optional<GroupPart> group_part_;
    std::vector<std::deque<Said>> verdicts_;  //!< per member
    Clock::time_point start_ = Clock::now();
    Clock::time_point mark_ = Clock::now();
    Clock::time_point looked_ = {};
};

}  // namespace sluice
