#include <algorithm>
#include <cctype>

#include "coupler/scene/parts.hpp"

namespace sluice {
namespace {

constexpr int first_port = 1024, last_port = 65535;

//! 127.A.B.C with numbers only: a name could lead anywhere.
bool is_loopback_number(std::string const& host)
{
    if (!host.starts_with("127.")) return false;
    int parts = 1;
    for (std::size_t at = 4; at <= host.size(); ++parts) {
        auto const end = std::min(host.find('.', at), host.size());
        auto const part = host.substr(at, end - at);
        bool const number = !part.empty() && part.size() <= 3 && part.find_first_not_of("0123456789") == part.npos;
        if (!number || std::stoi(part) > 255) return false;
        at = end + 1;
    }
    return parts == 4;
}

//! tcp://127.A.B.C:PORT
bool is_loopback_address(std::string const& address)
{
    constexpr std::string_view scheme = "tcp://";
    auto const colon = address.rfind(':');
    if (!address.starts_with(scheme) || colon <= scheme.size()) return false;
    auto const port = address.substr(colon + 1);
    bool const number = port.size() >= 4 && port.size() <= 5 && port.find_first_not_of("0123456789") == port.npos;
    return number && port[0] != '0' && std::stoi(port) >= first_port && std::stoi(port) <= 65000 &&
           is_loopback_number(address.substr(scheme.size(), colon - scheme.size()));
}

bool is_here(std::string const& host)
{
    return host.empty() || host == "localhost" || is_loopback_number(host);
}

void read_security(Reader& root, Scene& scene)
{
    if (root.is_scalar("security")) {
        scene.insecure = root.choice_or("security", 0, {"insecure"}) == 0;
        return;
    }
    auto security = root.child_if("security");
    if (!security) return;
    std::filesystem::path const keys = security->text("keys");
    if (!keys.empty()) scene.keys = keys.is_absolute() ? keys : scene.file.parent_path() / keys;
    security->finish();
}

//! A participant listens for those after it in the scene: they must be able to come.
void check_reach(Reader& root, Scene const& scene)
{
    auto participants = root.child("participants");
    for (std::size_t p = 0; p < scene.participants.size(); ++p) {
        auto const& spec = scene.participants[p];
        if (!is_here(spec.host)) continue;
        for (std::size_t q = p + 1; q < scene.participants.size(); ++q) {
            auto const& other = scene.participants[q];
            if (is_here(other.host)) continue;
            auto const text = "\"" + other.name + "\" on " + other.host +
                              " cannot reach a participant that listens on this host's loopback only (needs host: "
                              "ADDRESS of this host).";
            if (spec.host.empty())
                participants.problem(spec.name, text);
            else if (auto reader = participants.child_if(spec.name))
                reader->problem("host", text);
            break;
        }
    }
}

void check_hosts(Reader& root, Scene const& scene, bool secured)
{
    bool any = false;
    std::string const* foreign = nullptr;
    std::int64_t members = 0;
    for (auto const& spec : scene.participants) {
        any = any || !spec.host.empty();
        if (!is_here(spec.host) && !foreign) foreign = &spec.host;
        members += spec.ranks;
    }
    if (!any) {
        for (char const* key : {"port", "security", "remote"})
            if (root.has(key)) root.problem(key, "has no meaning while no participant has a host. Leave it out.");
        return;
    }
    if (!root.has("port"))
        root.problem("port", "is missing (participants have hosts: the first tcp port, 1024 to 65535, that they use).");
    else if (scene.port > 0 && scene.port + members * members - 1 > last_port)
        root.refuse("port", "is too high: " + std::to_string(members) + " processes use the ports up to " +
                                std::to_string(scene.port + members * members - 1) + " (at most 65535).");
    if (root.has("address")) root.problem("address", "contradicts hosts: with hosts give port.");
    if (scene.transport == TransportKind::shm || scene.transport == TransportKind::mpi)
        root.refuse("transport", "contradicts hosts: they are reached over tcp (zmq or auto).");
    if (!foreign) return;
    if (!secured)
        root.problem("security", "is missing: " + *foreign +
                                     " is another host. Give security: {keys: DIR} (made by `sluice keygen`) to "
                                     "encrypt, or security: insecure on a network that you trust.");
    check_reach(root, scene);
}

}  // namespace

std::string read_host(Reader& participant)
{
    auto const host = participant.word_if("host");
    auto const known = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
               std::string_view(".-_:").find(c) != std::string::npos;
    };
    bool const fine = host.size() <= 253 && !host.starts_with('-') && std::all_of(host.begin(), host.end(), known);
    if (!fine) participant.refuse("host", "is not an address or a name of a host (letters, digits, . - _ :).");
    return fine ? host : "";
}

void read_network(Reader& root, Scene& scene)
{
    scene.transport = static_cast<TransportKind>(root.choice_or("transport", 0, {"auto", "shm", "zmq", "mpi"}));
    scene.address = root.word_or("address", "ipc");
    if (scene.address == "ipc") scene.address.clear();
    bool const tcp = !scene.address.empty();
    if (tcp && (scene.transport == TransportKind::mpi || scene.transport == TransportKind::shm))
        root.refuse("address", "has no meaning with transport: mpi or shm. Leave it out.");
    if (tcp && !is_loopback_address(scene.address))
        root.refuse("address",
                    "(must be ipc or tcp://127.0.0.1:PORT, PORT from 1024 to 65000). To go beyond this host give "
                    "participants a host.");
    scene.port = static_cast<int>(root.integer_if("port", {.min = first_port, .max = last_port}).value_or(0));
    read_security(root, scene);
    scene.remote = root.words("remote");
    check_hosts(root, scene, root.has("security"));
}

}  // namespace sluice
