#pragma once

#include <deque>
#include <optional>

#include "coupler/bindings/call.hpp"
#include "coupler/bindings/sluice.h"
#include "coupler/coupler.hpp"

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
        sluice::bindings::misuse("column: the scene has no data \"" + std::string(data) + "\".");
    }
    Edge& edge(char const* from, char const* data)
    {
        for (auto& edge : edges)
            if (edge.from == from && edge.data == data) return edge;
        return edges.emplace_back(Edge{from, data, self.read(from, data, window), {}, {}});
    }

    //! A text that lives as long as the participant; the same one for the same content.
    char const* keep(std::string text)
    {
        for (auto const& kept : texts)
            if (kept == text) return kept.c_str();
        return texts.emplace_back(std::move(text)).c_str();
    }

    sluice::Participant self;
    sluice::Reader config;
    bool configured = false;
    std::deque<std::string> texts;  //!< that were handed out
    std::optional<sluice::Windows> windows;
    std::optional<sluice::Windows::Iterator> at;
    sluice::Window window;
    bool in_window = false;
    std::deque<Edge> edges;             //!< read in this window
    sluice::bindings::Failure failure;  //!< the first one; no call but the last works after it
};

namespace sluice::bindings {

//! `work` on a participant that has not failed before.
template <class Work>
int call(sluice_participant* self, char const* name, Work&& work) noexcept
{
    if (self && self->failure.status != 0)
        return note(self->failure.text, static_cast<sluice::Exit>(self->failure.status));
    int const status = status_of([&] {
        if (!self) misuse(std::string(name) + ": the participant is NULL. Look at what sluice_join() returned.");
        work();
    });
    if (self && status != 0) self->failure = last_failure;
    return status;
}

}  // namespace sluice::bindings
