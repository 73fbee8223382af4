// A participant's life and its configuration, for C. Arguments in, one call of Participant, exceptions to a status.

#include <cstdio>

#include "coupler/bindings/handle.hpp"
#include "coupler/command_line.hpp"

namespace sluice::bindings {
namespace {

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
}  // namespace sluice::bindings

using namespace sluice::bindings;

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
        bounds.unit = self->keep(&needed(unit, "number: unit"));  // whoever describes the scene looks at it later
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
        text = self->keep(fallback ? self->config.text_or(name, fallback) : self->config.text(name));
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

int sluice_fact(sluice_participant* self, char const* name, double value)
{
    return call(self, "fact", [&] { self->self.fact(&needed(name, "fact: name"), value); });
}

int sluice_warn(sluice_participant* self, char const* text)
{
    return call(self, "warn", [&] { self->self.warn(&needed(text, "warn: text")); });
}

}  // extern "C"
