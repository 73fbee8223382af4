#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

//! HDF5 archives read by somebody else's reader, to compare two of them.
namespace archive {

inline bool has_reader()
{
    return std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") == 0;
}

//! Every name, attribute, type, shape, chunk and value below the root, by name; "" when it cannot be read. Attributes
//! of the root (facts about the run) stay out.
inline std::string content(std::filesystem::path const& file)
{
    std::string const script =
        "import h5py,sys\n"
        "f=h5py.File(sys.argv[1])\n"
        "out=open(sys.argv[2],'w')\n"
        "def show(name,o):\n"
        " print(name,sorted((k,str(v)) for k,v in o.attrs.items()),file=out)\n"
        " if isinstance(o,h5py.Dataset): print(o.dtype,o.shape,o.chunks,o.compression,o[()].tobytes().hex(),file=out)\n"
        "f.visititems(show)\n";
    auto const listing = std::filesystem::temp_directory_path() / ("listing_" + std::to_string(::getpid()));
    std::string const command =
        "/usr/bin/python3 -c \"" + script + "\" '" + file.string() + "' '" + listing.string() + "'";
    bool const well = std::system(command.c_str()) == 0;
    std::stringstream text;
    if (well) text << std::ifstream(listing).rdbuf();
    std::filesystem::remove(listing);
    return text.str();
}

}  // namespace archive
