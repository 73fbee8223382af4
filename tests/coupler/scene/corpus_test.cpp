// Broken scenes, each with what is to be said about it in lines `#! LINE:COLUMN: TEXT => SUGGESTION` at its head. The
// places were marked by hand, where a person would look; goals from the specification of the command.

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>

#include "coupler/base/error.hpp"
#include "coupler/scene/scene.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/shell.hpp"

namespace {

struct Expected
{
    int line = 0, column = 0;
    std::string text, suggestion;
};

struct Said
{
    int line = 0, column = 0;
    std::string text;
};

std::vector<std::filesystem::path> corpus()
{
    std::vector<std::filesystem::path> files;
    for (auto const& entry : std::filesystem::directory_iterator(CORPUS)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<Expected> expected_in(std::string const& text)
{
    std::vector<Expected> all;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        Expected e;
        int length = 0;
        if (std::sscanf(line.c_str(), "#! %d:%d: %n", &e.line, &e.column, &length) != 2) continue;
        e.text = line.substr(static_cast<std::size_t>(length));
        if (auto const arrow = e.text.find(" => "); arrow != e.text.npos) {
            e.suggestion = e.text.substr(arrow + 4);
            e.text.resize(arrow);
        }
        all.push_back(e);
    }
    return all;
}

//! `FILE:LINE:COLUMN: TEXT` lines of a message.
std::vector<Said> said_in(std::string const& message, std::string const& file)
{
    std::vector<Said> all;
    std::istringstream lines(message);
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with(file + ":")) continue;
        Said s;
        int length = 0;
        line.erase(0, file.size());
        if (std::sscanf(line.c_str(), ":%d:%d: %n", &s.line, &s.column, &length) != 2) continue;
        s.text = line.substr(static_cast<std::size_t>(length));
        all.push_back(s);
    }
    return all;
}

std::string validated(std::string const& text, std::string const& file)
{
    try {
        sluice::load_scene_text(text, file).diagnostics->throw_if_any();
    } catch (sluice::Error const& e) {
        return e.what();
    }
    return "";
}

shell::Result checked(std::filesystem::path const& file, std::filesystem::path const& log)
{
    return shell::run({SLUICE_COMMAND, "check", file.string()}, log);
}

bool is_about_a_solver(std::filesystem::path const& file)
{
    return file.filename().string().starts_with("solver_");
}

//! What the validator says; about a solver's block, what the command says, since the solver reads it.
std::vector<Said> said_about(std::filesystem::path const& file, std::filesystem::path const& log)
{
    auto const text =
        is_about_a_solver(file) ? checked(file, log).output : validated(shell::slurp(file), file.string());
    return said_in(text, file.string());
}

bool suggests(std::string const& text, std::string const& word)
{
    return text.find("Did you mean " + word + "?") != text.npos;
}

}  // namespace

TEST_CASE("corpus: right lines, columns, suggestions, and all mistakes of a scene in one pass")
{
    in_threads::Scratch const scratch;
    int wanted = 0, columns = 0, typos = 0, suggestions = 0;
    auto const files = corpus();
    for (auto const& file : files) {
        CAPTURE(file.filename().string());
        auto const expected = expected_in(shell::slurp(file));
        auto const said = said_about(file, scratch.path() / "log");
        CHECK(!expected.empty());
        CHECK(said.size() == expected.size());
        for (auto const& e : expected) {
            ++wanted;
            CAPTURE(e.text);
            auto const found = std::find_if(said.begin(), said.end(), [&](Said const& s) {
                return s.line == e.line && s.text.find(e.text) != s.text.npos;
            });
            bool const there = found != said.end();
            if (!there)
                for (auto const& s : said) MESSAGE(s.line << ":" << s.column << ": " << s.text);
            CHECK(there);
            if (!there) continue;
            columns += found->column == e.column;
            if (found->column != e.column) MESSAGE("column " << found->column << " for " << e.column);
            if (e.suggestion.empty()) continue;
            ++typos;
            suggestions += suggests(found->text, e.suggestion);
            if (!suggests(found->text, e.suggestion))
                MESSAGE("no suggestion of " << e.suggestion << ": " << found->text);
        }
    }
    CHECK(files.size() >= 80);
    CHECK(typos >= 40);
    CHECK(columns >= 0.95 * wanted);
    CHECK(suggestions >= 0.9 * typos);
    MESSAGE(files.size() << " scenes, " << wanted << " mistakes, " << columns << " right columns, " << suggestions
                         << " of " << typos << " suggestions");
}

TEST_CASE("corpus: the command refuses every scene with exit 2, and JSON has the same mistakes")
{
    in_threads::Scratch const scratch;
    for (auto const& file : corpus()) {
        CAPTURE(file.filename().string());
        auto const result = shell::run({SLUICE_COMMAND, "check", "--json", file.string()}, scratch.path() / "log");
        CHECK(result.exit == 2);
        auto const answer = nlohmann::json::parse(result.output);
        CHECK(answer["ok"] == false);
        for (auto const& e : expected_in(shell::slurp(file))) {
            CAPTURE(e.text);
            CHECK(std::any_of(answer["mistakes"].begin(), answer["mistakes"].end(), [&](auto const& m) {
                return m.value("line", 0) == e.line && m.value("text", "").find(e.text) != std::string::npos;
            }));
        }
    }
}

TEST_CASE("corpus: a scene is judged in less than 50 ms, the best of three")
{
    using Clock = std::chrono::steady_clock;
    double longest = 0;
    for (auto const& file : corpus()) {
        CAPTURE(file.filename().string());
        auto const text = shell::slurp(file);
        double best = 1e9;
        for (int i = 0; i < 3; ++i) {
            auto const begin = Clock::now();
            validated(text, file.string());
            best = std::min(best, std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
        }
        CHECK(best < 50);
        longest = std::max(longest, best);
    }
    MESSAGE("longest: " << longest << " ms");
}
