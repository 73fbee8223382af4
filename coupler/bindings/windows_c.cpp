// Edges and windows, for C. The only logic is the order of calls that C++ enforces by its types.

#include "coupler/bindings/handle.hpp"

namespace sluice::bindings {
namespace {

std::vector<std::string> names_of(char const* const* list)
{
    std::vector<std::string> names;
    while (*list) names.emplace_back(*list++);
    return names;
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

}  // namespace
}  // namespace sluice::bindings

using namespace sluice::bindings;

extern "C" {

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
        found = k < names.size() ? self->keep(names[k]) : nullptr;
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

}  // extern "C"
