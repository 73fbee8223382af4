#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

//! Bounds on a number; a message names the one that was broken.
struct Bounds
{
    double above = -std::numeric_limits<double>::infinity();  //!< x > above
    double min = -std::numeric_limits<double>::infinity();    //!< x >= min
    double max = std::numeric_limits<double>::infinity();     //!< x <= max
    double below = std::numeric_limits<double>::infinity();   //!< x < below
    std::string_view unit = "";
};

//! A key as the code that reads it knows it. Readers write these down for whoever describes a scene: what is told about
//! a scene is what the code asks it.
struct Key
{
    enum class Kind
    {
        number,
        integer,
        flag,        //!< true or false
        text,        //!< any single word or number
        word,        //!< a text that YAML does not take for a number or a flag
        choice,      //!< one of `words`
        texts,       //!< a text, or a list of them
        name,        //!< of something that the scene defines
        names,       //!< a list of at least `size` of them
        numbers,     //!< a list of `size` numbers
        mapping,     //!< keys of its own
        named,       //!< name -> mapping
        list,        //!< of mappings
        number_map,  //!< name -> number
        open         //!< a mapping that others read
    };
    Kind kind;
    std::string path;                          //!< "couplings[0].lag"
    bool required = false;                     //!< its absence is a mistake
    Bounds bounds = {};                        //!< of numbers
    std::size_t size = 0;                      //!< of lists; where it varies, the smallest
    std::size_t largest = 0;                   //!< of lists whose size varies
    std::vector<std::string> words = {};       //!< of choices; the word that may stand for a number
    std::optional<std::string> fallback = {};  //!< what its absence means, as it would be written
};

}  // namespace sluice
