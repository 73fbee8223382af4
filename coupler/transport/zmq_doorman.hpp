#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupler/transport/keys.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {

//! What protects the connections of a run, and who may come: CURVE keys, or a word that all processes of the run know.
class Doorman
{
 public:
    //! Keys where members have hosts and the network has keys; else a word: on this host a secret of the run's private
    //! directory, elsewhere (`security: insecure`) one that keeps out noise and other runs, but nobody who means it.
    //! Throws Error (exit 7 or 8) if keys or secret cannot be read.
    Doorman(Members const& members, Network const& network);

    bool curve() const { return !public_keys_.empty(); }
    //! Makes `socket` of this member ask for (listener) or show (connecting) what is needed between it and `peer`.
    void protect(void* socket, int peer, bool listener) const;

    //! One request of the ZeroMQ authentication protocol (rfc.zeromq.org/spec/27).
    struct Request
    {
        std::string domain;  //!< number of the peer that the socket is for
        std::string mechanism;
        std::vector<std::string> credentials;
    };
    struct Verdict
    {
        int peer = -1;
        std::string refusal;  //!< why, for this side's user; empty: let in
    };
    Verdict judge(Request const& request) const;

 private:
    std::string judge_key(int peer, Request const& request) const;
    std::string judge_word(int peer, Request const& request) const;

    std::vector<std::string> names_;
    int self_;
    std::vector<std::string> public_keys_;  //!< per member; empty: no CURVE
    KeyPair own_;
    std::string word_;
};

}  // namespace sluice
