#include <cmath>
#include <cstdio>
#include <deque>
#include <new>
#include <optional>

#include "coupler/bindings/sluice.h"
#include "coupler/command_line.hpp"

//! The C interface over Participant: arguments in, one call, exceptions to a status. No physics, no logic of its own
//! but the order of calls that C++ enforces by its types.

namespace {

using namespace std::string_literals;

struct Failure
{
    std::string text;
    int status = 0;
};
thread_local Failure last_failure;

int note(std::string const& text, sluice::Exit exit) noexcept
{
    try {
        last_failure.text = text;
    } catch (...) {  // out of memory: the code has to do
        last_failure.text.clear();
    }
    return last_failure.status = static_cast<int>(exit);
}

//! The status of `work`: 0, or that of the exception that it ended with.
template <class Work>
int status_of(Work&& work) noexcept
{
    try {
        work();
        return 0;
    } catch (sluice::Error const& e) {
        return note(e.what(), e.exit());
    } catch (std::bad_alloc const&) {
        return note("out of memory. Make the scene smaller.", sluice::Exit::io);
    } catch (std::exception const& e) {
        return note(e.what() + " (a bug of ours)."s, sluice::Exit::internal);
    } catch (...) {
        return note("an exception of unknown kind (a bug of ours).", sluice::Exit::internal);
    }
}

//! A call that is wrong, which a program in C++ would not compile or would be told by an assert.
[[noreturn]] void misuse(std::string const& text)
{
    throw sluice::Error("sluice_" + text, sluice::Exit::internal);
}

void require_given(void const* pointer, char const* what)
{
    if (!pointer) misuse(what + " is NULL (needed)."s);
}

template <class T>
T& needed(T* pointer, char const* what)
{
    require_given(pointer, what);
    return *pointer;
}

std::vector<std::string> names_of(char const* const* list)
{
    std::vector<std::string> names;
    while (*list) names.emplace_back(*list++);
    return names;
}

template <class T>
std::span<T const> values_of(void const* values, std::size_t size)
{
    if (size > 0) require_given(values, "put: values");
    return {static_cast<T const*>(values), size};
}

}  // namespace

struct sluice_state
{
    sluice::State* saved = nullptr;           //!< in `save`
    sluice::State const* restored = nullptr;  //!< in `restore`
};

struct sluice_participant
{
    //! What sluice_frame points to, for one edge.
    struct Edge
    {
        std::string from, data;
        sluice::Samples samples;
        std::vector<double const*> column;
        std::vector<std::size_t> components;
    };

    explicit sluice_participant(sluice::JoinOptions options) : self(std::move(options)), config(self.config()) {}

    sluice::DataSpec const& spec(std::string_view data) const
    {
        for (auto const& spec : self.scene().data)
            if (spec.name == data) return spec;
        misuse("column: the scene has no data \"" + std::string(data) + "\".");
    }
    Edge& edge(char const* from, char const* data)
    {
        for (auto& edge : edges)
            if (edge.from == from && edge.data == data) return edge;
        return edges.emplace_back(Edge{from, data, self.read(from, data, window), {}, {}});
    }

    sluice::Participant self;
    sluice::Reader config;
    bool configured = false;
    std::deque<std::string> texts;  //!< that were handed out
    std::optional<sluice::Windows> windows;
    std::optional<sluice::Windows::Iterator> at;
    sluice::Window window;
    bool in_window = false;
    std::deque<Edge> edges;  //!< read in this window
    Failure failure;         //!< the first one; no call but the last works after it
};

namespace {

//! `work` on a participant that has not failed before.
template <class Work>
int call(sluice_participant* self, char const* name, Work&& work) noexcept
{
    if (self && self->failure.status != 0)
        return note(self->failure.text, static_cast<sluice::Exit>(self->failure.status));
    int const status = status_of([&] {
        if (!self) misuse(name + ": the participant is NULL. Look at what sluice_join() returned."s);
        work();
    });
    if (self && status != 0) self->failure = last_failure;
    return status;
}

void describe(sluice_participant const& p, sluice_about& about)
{
    auto const& scene = p.self.scene();
    about.name = p.self.name().c_str();
    about.directory = p.self.directory().c_str();
    about.scene = scene.file.c_str();
    for (std::size_t k = 0; k < 3; ++k) about.gravity[k] = scene.gravity[k];
    about.end = scene.end;
    about.resumed_at = p.self.resumed_at();
    about.dimension = scene.dimension;
    about.rank = p.self.rank();
    about.ranks = p.self.ranks();
    about.checking = p.self.checking();
    about.resumes = p.self.resumes();
}

void read(sluice_participant& p, char const* from, char const* data, double time, sluice_frame& frame)
{
    if (!p.in_window) misuse("read: no window is being computed (needed: sluice_next() with more = 1 before).");
    double const slack = 1e-9 * p.window.length;  // of times that the solver adds up from its steps
    if (!(time >= p.window.begin - slack && time <= p.window.end + slack))
        misuse("read: t = " + std::to_string(time) + " s is not in the window (" + std::to_string(p.window.begin) +
               " to " + std::to_string(p.window.end) + " s).");
    auto& edge = p.edge(&needed(from, "read: from"), &needed(data, "read: data"));
    auto const& columns = edge.samples.columns(time);
    auto const ids = edge.samples.ids();
    edge.column.clear();
    edge.components.clear();
    for (auto const& column : columns) edge.column.push_back(column.data());
    for (auto const& column : p.spec(data).columns)
        edge.components.push_back(static_cast<std::size_t>(sluice::components(column.shape, p.self.scene().dimension)));
    frame = {ids.size(), ids.data(), columns.size(), edge.column.data(), edge.components.data()};
}

void next(sluice_participant& p, sluice_window& window, int& more)
{
    p.in_window = false;
    p.edges.clear();
    if (!p.configured) p.config.finish();
    p.configured = true;
    if (!p.windows) {
        p.windows.emplace(p.self.windows());
        p.at.emplace(p.windows->begin());
    } else if (*p.at != p.windows->end())
        ++*p.at;
    p.in_window = *p.at != p.windows->end();
    more = p.in_window;
    if (!p.in_window) return;
    auto const& w = p.window = **p.at;
    window = {w.index, w.begin, w.end, w.length, w.output, w.series, w.last, w.iteration};
}

void request(sluice::Participant& self, int what, double seconds, char const* why)
{
    switch (what) {
        case SLUICE_NEXT_WINDOW:
            return self.next_window(seconds);
        case SLUICE_END_RUN:
            return self.end_run(&needed(why, "request: why"));
        case SLUICE_CHECKPOINT:
            return self.request_checkpoint();
        default:
            misuse("request: there is no request " + std::to_string(what) + ".");
    }
}

//! `callback` of the solver, whose failure becomes that of the call around it.
void run_callback(int (*callback)(void*, sluice_state*), void* context, sluice_state state, char const* what)
{
    last_failure = {};
    int const status = callback(context, &state);
    if (status == 0) return;
    throw sluice::Error(last_failure.text.empty() ? "the solver could not "s + what + " its state." : last_failure.text,
                        static_cast<sluice::Exit>(status));
}

//! Tells the peers, the launcher and standard error.
int fail(sluice_participant& p, int status, std::string const& text)
{
    p.self.fail(sluice::Error(text, static_cast<sluice::Exit>(status)));
    std::fprintf(stderr, "%s\n", text.c_str());
    return sluice::exit_for_launcher(status);
}

int leave(sluice_participant* p, int status, char const* message)
{
    std::string const text = message ? message : last_failure.text;
    if (!p) {
        if (status != 0 && !text.empty()) std::fprintf(stderr, "%s\n", text.c_str());
        return status;
    }
    if (status != 0) return fail(*p, status, text);
    if (p->failure.status != 0) return fail(*p, p->failure.status, p->failure.text);  // nobody looked
    int exit = 0;
    if (!p->self.checking()) status = status_of([&] { exit = p->self.finish(); });
    return status == 0 ? sluice::exit_for_launcher(exit) : fail(*p, status, last_failure.text);
}

}  // namespace

extern "C" {

char const* sluice_version(int* abi)
{
    if (abi) *abi = SLUICE_ABI;
    return SLUICE_VERSION;
}

char const* sluice_error(int* status)
{
    if (status) *status = last_failure.status;
    return last_failure.text.c_str();
}

int sluice_join(int abi, int argc, char const* const* argv, sluice_participant** self)
{
    if (self) *self = nullptr;
    last_failure = {};
    int code = 0;
    int const status = status_of([&] {
        auto& joined = needed(self, "join: self");
        needed(argv, "join: argv");
        sluice::require(abi == SLUICE_ABI, [&] {
            return sluice::Error("libsluice_c has interface " + std::to_string(SLUICE_ABI) +
                                     ", the program was made for " + std::to_string(abi) +
                                     " (must match). Compile it with the sluice.h of Sluice " SLUICE_VERSION
                                     ", or use that version's sluice.py.",
                                 sluice::Exit::protocol);
        });
        sluice::JoinOptions options;
        code = sluice::parse_command_line(argc, argv, options);
        if (code >= 0) return;
        sluice::heed_signals();
        joined = new sluice_participant(std::move(options));
    });
    return status != 0 ? status : std::max(code, 0);
}

int sluice_get_about(sluice_participant* self, sluice_about* about)
{
    return call(self, "get_about", [&] { describe(*self, needed(about, "get_about: about")); });
}

int sluice_leave(sluice_participant* self, int status, char const* message)
{
    std::unique_ptr<sluice_participant> const gone(self);
    int exit = status;
    int const failure = status_of([&] { exit = leave(self, status, message); });
    return failure != 0 ? failure : exit;
}

int sluice_number(sluice_participant* self, char const* key, char const* unit, size_t count, double const* fallback,
                  double* values)
{
    return call(self, "number", [&] {
        sluice::Bounds bounds;
        bounds.unit = &needed(unit, "number: unit");
        std::string const name = &needed(key, "number: key");
        double& first = needed(values, "number: values");
        if (count == 1) {
            first = fallback ? self->config.number_or(name, *fallback, bounds) : self->config.number(name, bounds);
            return;
        }
        auto const numbers =
            fallback ? self->config.numbers_or(name, std::vector<double>(fallback, fallback + count), bounds)
                     : self->config.numbers(name, count, bounds);
        for (std::size_t k = 0; k < count; ++k) values[k] = k < numbers.size() ? numbers[k] : 0;
    });
}

int sluice_text(sluice_participant* self, char const* key, char const* fallback, char const** value)
{
    return call(self, "text", [&] {
        auto& text = needed(value, "text: value");
        std::string const name = &needed(key, "text: key");
        text =
            self->texts.emplace_back(fallback ? self->config.text_or(name, fallback) : self->config.text(name)).c_str();
    });
}

int sluice_flag(sluice_participant* self, char const* key, int fallback, int* value)
{
    return call(self, "flag",
                [&] { needed(value, "flag: value") = self->config.flag_or(&needed(key, "flag: key"), fallback != 0); });
}

int sluice_refuse(sluice_participant* self, char const* key, char const* text)
{
    return call(self, "refuse",
                [&] { self->config.refuse(&needed(key, "refuse: key"), &needed(text, "refuse: text")); });
}

int sluice_end_config(sluice_participant* self)
{
    return call(self, "end_config", [&] {
        self->configured = true;
        self->config.finish();
    });
}

int sluice_exchanges(sluice_participant* self, char const* const* sends, char const* const* takes)
{
    return call(self, "exchanges", [&] {
        if (sends) self->self.sends(names_of(sends));
        if (takes) self->self.takes(names_of(takes));
    });
}

int sluice_partner(sluice_participant* self, char const* data, int outgoing, size_t k, char const** name)
{
    return call(self, "partner", [&] {
        auto& found = needed(name, "partner: name");
        auto const* const wanted = &needed(data, "partner: data");
        auto const names = outgoing ? self->self.receivers(wanted) : self->self.senders(wanted);
        found = k < names.size() ? self->texts.emplace_back(names[k]).c_str() : nullptr;
    });
}

int sluice_column(sluice_participant* self, char const* data, size_t k, char const** name, char const** unit,
                  size_t* components)
{
    return call(self, "column", [&] {
        auto& its_name = needed(name, "column: name");
        auto const& columns = self->spec(&needed(data, "column: data")).columns;
        its_name = k < columns.size() ? columns[k].name.c_str() : nullptr;
        if (!its_name) return;
        needed(unit, "column: unit") = columns[k].unit.c_str();
        needed(components, "column: components") =
            static_cast<std::size_t>(sluice::components(columns[k].shape, self->self.scene().dimension));
    });
}

int sluice_propose_window(sluice_participant* self, double seconds, int exact)
{
    return call(self, "propose_window", [&] { self->self.propose_window(seconds, exact != 0); });
}

int sluice_covers(sluice_participant* self, double const* min, double const* max)
{
    return call(self, "covers", [&] {
        needed(min, "covers: min");
        needed(max, "covers: max");
        self->self.covers({{min[0], min[1], min[2]}, {max[0], max[1], max[2]}});
    });
}

int sluice_keeps(sluice_participant* self, int (*save)(void*, sluice_state*), int (*restore)(void*, sluice_state*),
                 void* context)
{
    return call(self, "keeps", [&] {
        if (!save || !restore) misuse("keeps: save or restore is NULL (both are needed).");
        self->self.keeps(
            [=](sluice::State& state) {
                run_callback(save, context, {&state, nullptr}, "save");
            },
            [=](sluice::State const& state) {
                run_callback(restore, context, {nullptr, &state}, "restore");
            });
    });
}

int sluice_put(sluice_state* state, char const* name, int type, void const* values, size_t size)
{
    return status_of([&] {
        auto& saved = needed(needed(state, "put: state").saved, "put: the state is being restored; its saved part");
        std::string const key = &needed(name, "put: name");
        if (type == SLUICE_FLOAT64)
            saved.put(key, values_of<double>(values, size));
        else if (type == SLUICE_INT64)
            saved.put(key, values_of<std::int64_t>(values, size));
        else if (type == SLUICE_BYTES)
            saved.put(key, values_of<std::byte>(values, size));
        else
            misuse("put: there is no type " + std::to_string(type) + ".");
    });
}

int sluice_get(sluice_state* state, char const* name, int type, void const** values, size_t* size)
{
    return status_of([&] {
        auto const& kept =
            needed(needed(state, "get: state").restored, "get: the state is being saved; its restored part");
        std::string const key = &needed(name, "get: name");
        auto const give = [&](auto found) {
            needed(values, "get: values") = found.data();
            needed(size, "get: size") = found.size();
        };
        if (type == SLUICE_FLOAT64)
            give(kept.numbers(key));
        else if (type == SLUICE_INT64)
            give(kept.integers(key));
        else if (type == SLUICE_BYTES)
            give(kept.bytes(key));
        else
            misuse("get: there is no type " + std::to_string(type) + ".");
    });
}

int sluice_write(sluice_participant* self, char const* to, char const* data, size_t points, int64_t const* ids,
                 size_t columns, double const* const* column, size_t const* size)
{
    return call(self, "write", [&] {
        if (points > 0) needed(ids, "write: ids");
        if (columns > 0) needed(column, "write: column"), needed(size, "write: size");
        std::vector<std::span<double const>> spans;
        for (std::size_t c = 0; c < columns; ++c) {
            if (size[c] > 0) needed(column[c], "write: a column");
            spans.emplace_back(column[c], size[c]);
        }
        self->self.write(&needed(to, "write: to"), &needed(data, "write: data"), {ids, points}, spans);
    });
}

int sluice_next(sluice_participant* self, sluice_window* window, int* more)
{
    return call(self, "next", [&] { next(*self, needed(window, "next: window"), needed(more, "next: more")); });
}

int sluice_read(sluice_participant* self, char const* from, char const* data, double time, sluice_frame* frame)
{
    return call(self, "read", [&] { read(*self, from, data, time, needed(frame, "read: frame")); });
}

int sluice_accepted(sluice_participant* self, int* yes)
{
    return call(self, "accepted", [&] {
        if (!self->in_window) misuse("accepted: no window is being computed.");
        needed(yes, "accepted: yes") = self->self.accepted(self->window);
    });
}

int sluice_request(sluice_participant* self, int what, double seconds, char const* why)
{
    return call(self, "request", [&] { request(self->self, what, seconds, why); });
}

int sluice_fact(sluice_participant* self, char const* name, double value)
{
    return call(self, "fact", [&] { self->self.fact(&needed(name, "fact: name"), value); });
}

int sluice_warn(sluice_participant* self, char const* text)
{
    return call(self, "warn", [&] { self->self.warn(&needed(text, "warn: text")); });
}

}  // extern "C"
