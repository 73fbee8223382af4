#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "coupler/scene/diagnostics.hpp"

namespace sluice {

//! Reads one mapping of a scene, key by key, and knows its own path ("participants.grains.config.contact").
//! Every getter records a Problem instead of throwing and returns a harmless value, so that all mistakes are listed
//! at once; `finish()` reports the keys that nobody asked for and, on the outermost reader, throws the list.
class Reader
{
 public:
    Reader(YAML::Node node, YAML::Node key, std::string path, std::shared_ptr<Diagnostics> diagnostics, bool outermost);

    double number(std::string_view key, Bounds const& bounds = {});
    double number_or(std::string_view key, double fallback, Bounds const& bounds = {});
    std::optional<double> number_if(std::string_view key, Bounds const& bounds = {});
    std::int64_t integer(std::string_view key, Bounds const& bounds = {});
    std::optional<std::int64_t> integer_if(std::string_view key, Bounds const& bounds = {});
    std::int64_t integer_or(std::string_view key, std::int64_t fallback, Bounds const& bounds = {});
    //! A number, or nothing where the key is absent or says `word`, e.g. auto.
    std::optional<double> number_unless(std::string_view key, std::string_view word, Bounds const& bounds = {});
    bool flag_or(std::string_view key, bool fallback);  //!< true or false
    std::string text(std::string_view key);
    std::string text_or(std::string_view key, std::string_view fallback);
    std::string text_if(std::string_view key);  //!< absent: empty
    //! A text that YAML does not take for a number or a flag, where it could be mistaken for one.
    std::string word(std::string_view key);
    std::string word_if(std::string_view key);  //!< absent: empty
    std::string word_or(std::string_view key, std::string_view fallback);
    //! One of `choices`, returned as its index. A wrong word gets the nearest choice.
    std::size_t choice(std::string_view key, std::vector<std::string_view> const& choices);
    std::size_t choice_or(std::string_view key, std::size_t fallback, std::vector<std::string_view> const& choices);
    std::vector<std::string> words(std::string_view key);  //!< a text, or a list of them; absent: empty
    //! A name out of `known`, which the scene itself defines, as its index; `kind` says of what, e.g. "participant".
    std::optional<std::size_t> name_of(std::string_view key, std::string_view kind,
                                       std::vector<std::string> const& known);
    std::optional<std::size_t> name_of_if(std::string_view key, std::string_view kind,
                                          std::vector<std::string> const& known);
    //! A list of at least `least` different ones.
    std::vector<std::size_t> names_of(std::string_view key, std::string_view kind,
                                      std::vector<std::string> const& known, std::size_t least);
    //! A list of `size` numbers, e.g. [0, -9.81].
    std::vector<double> numbers(std::string_view key, std::size_t size, Bounds const& bounds = {});
    std::vector<double> numbers_or(std::string_view key, std::vector<double> const& fallback,
                                   Bounds const& bounds = {});

    Reader child(std::string_view key);                    //!< a mapping that must be there
    Reader child_or_empty(std::string_view key);           //!< a mapping; one without keys if it is absent
    std::optional<Reader> child_if(std::string_view key);  //!< a mapping that may be there
    std::vector<Reader> list(std::string_view key);        //!< a list of mappings; absent: empty
    std::vector<std::pair<std::string, Reader>> children(std::string_view key);     //!< name -> mapping, in file order
    std::vector<std::pair<std::string, Reader>> children_if(std::string_view key);  //!< the same; absent: empty

    //! This mapping as names with a number each.
    std::vector<std::pair<std::string, double>> number_map(Bounds const& bounds);

    bool has(std::string_view key) const;
    bool is_scalar(std::string_view key) const;  //!< present and a single word or number, not a mapping or list
    bool is_list(std::string_view key) const;    //!< present and a list
    std::string const& path() const { return path_; }
    std::vector<std::string> keys() const;
    YAML::Node key_of(std::string_view key) const { return key_node(key); }  //!< the key itself, else this mapping's
    Problem place(std::string_view key) const;                               //!< where the key stands, without a text
    std::optional<YAML::Node> subtree(std::string_view key);  //!< taken as it is, for somebody else to read

    //! Records a mistake at `key` (or at this mapping if the key is absent): `path.key: text`.
    void problem(std::string_view key, std::string const& text);
    //! Records that the value of `key` will not do, at the value: `path.key = value text`.
    void refuse(std::string_view key, std::string const& text);
    //! Notes at the value of `key` what is no mistake but looks like one: `path.key = value text`.
    void warn(std::string_view key, std::string const& text);
    //! Unknown keys become problems, with the nearest known name. The outermost reader then throws if there is any.
    void finish();
    void finish_collecting();  //!< the same without the throw
    std::shared_ptr<Diagnostics> const& diagnostics() const { return diagnostics_; }

 private:
    std::optional<YAML::Node> find(std::string_view key);
    void learn(std::string_view key, Key what) const;  //!< writes down what is asked, if somebody wants to know
    std::string find_text(std::string_view key, bool word);
    std::optional<Reader> find_child(std::string_view key);
    std::vector<std::pair<std::string, Reader>> find_children(std::string_view key);
    YAML::Node key_node(std::string_view key) const;
    Reader nothing_at(std::string_view key) const;  //!< an empty mapping whose mistakes nobody hears of
    YAML::Mark value_mark(std::string_view key, YAML::Node const& value) const;
    Problem at(YAML::Mark const& mark) const;
    std::string path_of(std::string_view key) const;
    void record(YAML::Mark const& mark, std::string const& text);
    void missing(std::string_view key, std::string_view needed);
    std::optional<double> parse_number(std::string_view key, YAML::Node const& node, std::string const& path,
                                       Bounds const& bounds);
    std::optional<double> scalar_number(std::string_view key, Bounds const& bounds, bool must, bool whole);
    std::optional<std::size_t> find_choice(std::string_view key, std::vector<std::string_view> const& choices,
                                           bool must);
    std::optional<std::size_t> find_name(std::string_view key, std::string const& path, YAML::Node const& node,
                                         std::string_view kind, std::vector<std::string> const& known);
    std::optional<std::vector<double>> find_numbers(std::string_view key, std::size_t size, Bounds const& bounds,
                                                    bool must);
    template <class T>
    T note(std::string_view key, T value);

    YAML::Node node_;  //!< the mapping
    YAML::Node key_;   //!< the key that led here, for messages about the mapping as a whole
    std::string path_;
    std::shared_ptr<Diagnostics> diagnostics_;
    bool outermost_;
    std::set<std::string, std::less<>> asked_;
};

//! Parses a YAML text (at most 1 MB, 32 levels, 100 000 nodes, one document) and applies `path=value` overrides.
//! Returns the outermost reader. Throws Error (exit 2) with file:line:column on a syntax error or a broken limit.
Reader read_yaml(std::string const& text, std::string const& file, std::vector<std::string> const& overrides = {});
//! The text of a scene's file. Throws Error (exit 2) if it cannot be read.
std::string read_scene_file(std::filesystem::path const& file);
Reader read_yaml_file(std::filesystem::path const& file, std::vector<std::string> const& overrides = {});

}  // namespace sluice
