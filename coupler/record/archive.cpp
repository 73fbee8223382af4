#include "coupler/record/archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <numeric>
#include <type_traits>

#include "coupler/base/error.hpp"
#include "coupler/record/archive_steps.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/descriptor.hpp"
#include "coupler/record/disk_space.hpp"
#include "coupler/record/hdf5_handle.hpp"

namespace sluice {
namespace {

using hdf5::check;
using hdf5::Handle;
static_assert(std::is_same_v<hid_t, std::int64_t>, "archive.hpp keeps HDF5 ids without including its header");

//! Room for object headers, symbol tables and the growth of the group's name heap, per step and per dataset or chunk;
//! a test compares it with what HDF5 takes.
constexpr std::uint64_t room_per_step = 128 * 1024;
constexpr std::uint64_t room_per_dataset = 8 * 1024;
//! Chunks of whole rows, near 256 kB: large enough for deflate, small enough for HDF5's 1 MB chunk cache.
constexpr std::size_t chunk_bytes = 256 * 1024;

constexpr unsigned most_links = 65535;  //!< in a group's header, HDF5's limit
constexpr unsigned roomy_steps = 1024, step_digits = 6;

template <class Value>
hid_t type_of()
{
    if constexpr (std::is_same_v<Value, double>) return H5T_IEEE_F64LE;
    if constexpr (std::is_same_v<Value, float>) return H5T_IEEE_F32LE;
    return H5T_STD_I64LE;
}

std::size_t product(std::vector<std::size_t> const& shape)
{
    return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

std::uint64_t raw_bytes(ArchiveDataset const& dataset)
{
    return std::visit([](auto values) { return static_cast<std::uint64_t>(values.size_bytes()); }, dataset.values);
}

std::uint64_t room_for(std::span<ArchiveDataset const> datasets)
{
    std::uint64_t room = room_per_step;
    for (auto const& dataset : datasets) {
        std::uint64_t const raw = raw_bytes(dataset);
        room += raw + raw / 64 + room_per_dataset;  // a chunk that deflate cannot shrink is stored raw, plus its index
    }
    return room;
}

//! Property lists: no modification times in files and objects.
Handle creation_list(hid_t kind)
{
    Handle list(H5Pcreate(kind), H5Pclose, "HDF5 property list");
    check(H5Pset_obj_track_times(list.get(), false), "HDF5 property list");
    return list;
}

Handle access_list()
{
    Handle list(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "HDF5 property list");
    check(H5Pset_file_locking(list.get(), false, true), "HDF5 property list");  // a report may read a run that goes on
    return list;
}

void write_attribute(hid_t object, std::string const& name, std::string const& text)
{
    std::string const what = "attribute " + name;
    Handle const type(H5Tcopy(H5T_C_S1), H5Tclose, what);
    check(H5Tset_size(type.get(), std::max<std::size_t>(text.size(), 1)), what);
    check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), what);
    check(H5Tset_cset(type.get(), H5T_CSET_UTF8), what);
    Handle const space(H5Screate(H5S_SCALAR), H5Sclose, what);
    Handle attribute(H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                     what);
    check(H5Awrite(attribute.get(), type.get(), text.c_str()), what);
    attribute.close(what);
}

void write_attribute(hid_t object, std::string const& name, std::span<double const> values, bool scalar)
{
    std::string const what = "attribute " + name;
    hsize_t const size = values.size();
    Handle const space(scalar ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose, what);
    Handle attribute(H5Acreate2(object, name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                     what);
    check(H5Awrite(attribute.get(), H5T_NATIVE_DOUBLE, values.data()), what);
    attribute.close(what);
}

void write_fact(hid_t file, ArchiveFact const& fact)
{
    if (auto const* text = std::get_if<std::string>(&fact.value)) write_attribute(file, fact.name, *text);
    if (auto const* number = std::get_if<double>(&fact.value)) write_attribute(file, fact.name, {number, 1}, true);
    if (auto const* list = std::get_if<std::vector<double>>(&fact.value))
        write_attribute(file, fact.name, *list, false);
}

Handle dataset_list(ArchiveDataset const& dataset, std::vector<hsize_t> const& shape)
{
    Handle list = creation_list(H5P_DATASET_CREATE);
    std::uint64_t const bytes = raw_bytes(dataset);
    if (dataset.pack == Pack::plain || bytes == 0 || shape.empty()) return list;
    std::vector<hsize_t> chunk = shape;
    chunk[0] = std::clamp<hsize_t>(chunk_bytes / (bytes / shape[0]), 1, shape[0]);
    check(H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data()), "HDF5 chunks");
    check(H5Pset_shuffle(list.get()), "HDF5 shuffle");
    check(H5Pset_deflate(list.get(), 1), "HDF5 deflate");
    return list;
}

void write_dataset(hid_t group, ArchiveDataset const& dataset)
{
    std::string const name(dataset.name);
    std::string const what = "dataset " + name;
    std::vector<hsize_t> const shape(dataset.shape.begin(), dataset.shape.end());
    Handle const space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose, what);
    Handle const list = dataset_list(dataset, shape);
    std::visit(
        [&](auto values) {
            assert(values.size() == product(dataset.shape));
            hid_t const type = type_of<typename decltype(values)::value_type>();
            Handle array(H5Dcreate2(group, name.c_str(), type, space.get(), H5P_DEFAULT, list.get(), H5P_DEFAULT),
                         H5Dclose, what);
            if (!dataset.unit.empty()) write_attribute(array.get(), "unit", std::string(dataset.unit));
            if (!values.empty()) check(H5Dwrite(array.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), what);
            array.close(what);
        },
        dataset.values);
}

//! The group `steps` keeps its links in its own header, made large enough for `roomy_steps` of them: to link a step
//! changes one block of the file, which a kill cannot split.
void make_step_list(hid_t file)
{
    Handle const list = creation_list(H5P_GROUP_CREATE);
    check(H5Pset_link_creation_order(list.get(), H5P_CRT_ORDER_TRACKED), "HDF5 group");  // makes it such a group
    check(H5Pset_link_phase_change(list.get(), most_links, most_links), "HDF5 group");
    check(H5Pset_est_link_info(list.get(), roomy_steps, step_digits), "HDF5 group");
    Handle(H5Gcreate2(file, "steps", H5P_DEFAULT, list.get(), H5P_DEFAULT), H5Gclose, "group steps").close("group");
}

void move_file(std::filesystem::path const& from, std::filesystem::path const& to)
{
    std::error_code error;
    std::filesystem::rename(from, to, error);
    if (error) throw_io(to, "rename into place", error.value());
}

void check_space_for_header(std::filesystem::path const& path)
{
    make_folder(path.parent_path());
    write_atomically(path, "");  // says why when the folder does not allow it; HDF5 then replaces it
    reserve_space(path, room_per_step);
}

}  // namespace

Archive::Archive(std::filesystem::path path, std::span<ArchiveFact const> facts, std::optional<double> keep_until)
    : path_(std::move(path))
{
    hdf5::forbid_exit_handler();
    hdf5::Quiet const quiet;
    if (!keep_until || !std::filesystem::exists(path_)) {
        create(path_, facts);
        return;
    }
    std::filesystem::path aside = path_;
    aside += ".partial";
    create(aside, facts);
    try {
        reserve_space(aside, std::filesystem::file_size(path_) + room_per_step);
        take_steps_of(path_, *keep_until);
        check(H5Fflush(file_, H5F_SCOPE_LOCAL), aside.string());
        move_file(aside, path_);
    } catch (...) {
        H5Fclose(std::exchange(file_, -1));
        throw;
    }
}

void Archive::create(std::filesystem::path const& path, std::span<ArchiveFact const> facts)
{
    check_space_for_header(path);
    Handle const creation = creation_list(H5P_FILE_CREATE);
    Handle const access = access_list();
    file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get());
    check(file_ < 0 ? -1 : 0, path.string() + ": cannot make the archive");
    try {
        reserve_space(path, room_per_step);
        for (auto const& fact : facts) write_fact(file_, fact);
        make_step_list(file_);
        check(H5Fflush(file_, H5F_SCOPE_LOCAL), path.string());
    } catch (...) {
        H5Fclose(std::exchange(file_, -1));
        throw;
    }
}

void Archive::take_steps_of(std::filesystem::path const& earlier, double keep_until)
{
    auto const [count, damage] = copy_steps(earlier, file_, keep_until);
    steps_ = count;
    if (damage.empty()) return;
    std::filesystem::path damaged = earlier;
    damaged += ".damaged";
    move_file(earlier, damaged);
    damage_ = fmt::format("could not be read up to t = {} s ({}), it is {} now", keep_until, damage,
                          damaged.filename().string());
}

std::string Archive::remark(std::size_t expected) const
{
    if (damage_.empty() && steps_ >= expected) return {};
    return fmt::format("{}: {}. It goes on with {} of {} earlier steps; the other files of the run have all.",
                       path_.string(), damage_.empty() ? "not as this run left it, or not there" : damage_, steps_,
                       expected);
}

Archive::~Archive()
{
    if (file_ < 0 || broken_) return;  // a broken file stays open: to close it would write once more
    hdf5::Quiet const quiet;
    H5Fclose(file_);
    release_reserve(path_);
}

void Archive::close()
{
    if (file_ < 0 || broken_) return;
    hdf5::Quiet const quiet;
    herr_t const status = H5Fclose(std::exchange(file_, -1));
    release_reserve(path_);
    check(status, path_.string() + ": cannot close the archive");
}

void Archive::append(double time, std::span<ArchiveDataset const> datasets)
{
    require(file_ >= 0 && !broken_, [&] {
        return Error(fmt::format("{}: takes no more steps, an earlier write failed or it is closed.", path_.string()),
                     Exit::io);
    });
    reserve_space(path_, room_for(datasets));
    hdf5::Quiet const quiet;
    broken_ = true;
    try {
        write_step(time, datasets);
    } catch (Error const& error) {
        throw Error(fmt::format("{}: step {}: {}", path_.string(), steps_, error.what()), Exit::io);
    }
    broken_ = false;
    ++steps_;
}

//! The step reaches the file before the link to it: a kill at any moment leaves a file in which all steps are whole.
void Archive::write_step(double time, std::span<ArchiveDataset const> datasets)
{
    Handle const list = creation_list(H5P_GROUP_CREATE);
    Handle group(H5Gcreate_anon(file_, list.get(), H5P_DEFAULT), H5Gclose, "group");
    write_attribute(group.get(), "time", {&time, 1}, true);
    for (auto const& dataset : datasets) write_dataset(group.get(), dataset);
    check(H5Fflush(file_, H5F_SCOPE_LOCAL), "flush");
    check(H5Olink(group.get(), file_, step_name(steps_).c_str(), H5P_DEFAULT, H5P_DEFAULT), "link");
    group.close("group");
    check(H5Fflush(file_, H5F_SCOPE_LOCAL), "flush");
}

void link_archives(std::filesystem::path const& path, std::span<ArchiveLink const> links)
{
    hdf5::forbid_exit_handler();
    hdf5::Quiet const quiet;
    std::filesystem::path aside = path;
    aside += ".partial";
    check_space_for_header(aside);
    Handle const creation = creation_list(H5P_FILE_CREATE);
    Handle const access = access_list();
    Handle file(H5Fcreate(aside.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose, aside.string());
    reserve_space(aside, room_per_step);
    for (auto const& link : links)
        check(H5Lcreate_external(link.file.c_str(), "/", file.get(), link.name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
              "link " + link.name);
    file.close(aside.string());
    release_reserve(aside);
    move_file(aside, path);
}

}  // namespace sluice
