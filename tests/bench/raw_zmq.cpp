#include <zmq.h>

#include <stdexcept>
#include <string>

#include "tests/bench/raw.hpp"

namespace bench {
namespace {

//! PAIR sockets, side 0 binds; zmq_send copies in, zmq_recv copies out.
class RawZmq final : public Way
{
 public:
    RawZmq(Setting const& setting, std::string const& endpoint)
        : side_(setting.side),
          context_(zmq_ctx_new()),
          socket_(zmq_socket(context_, ZMQ_PAIR)),
          field_(setting.most_points),
          copy_(setting.most_points)
    {
        auto const attach = side_ == 0 ? zmq_bind : zmq_connect;
        if (attach(socket_, endpoint.c_str()) != 0) throw std::runtime_error(endpoint + ": " + zmq_strerror(errno));
    }
    RawZmq(RawZmq const&) = delete;
    RawZmq& operator=(RawZmq const&) = delete;
    ~RawZmq() override
    {
        zmq_close(socket_);
        zmq_ctx_term(context_);
    }

    void round_trip(std::size_t points) override
    {
        if (side_ == 0) send(points);
        auto const room = copy_.of(points);
        if (zmq_recv(socket_, room.data(), room.size(), 0) != static_cast<int>(room.size()))
            throw std::runtime_error("zmq_recv: not what was sent");
        if (side_ == 1) send(points);
    }

 private:
    void send(std::size_t points)
    {
        auto const bytes = field_.of(points);
        if (zmq_send(socket_, bytes.data(), bytes.size(), 0) < 0) throw std::runtime_error("zmq_send failed");
    }

    int side_;
    void* context_;
    void* socket_;
    Field field_, copy_;
};

}  // namespace

std::unique_ptr<Way> raw_zmq_ipc(Setting const& setting)
{
    return std::make_unique<RawZmq>(setting, "ipc://" + (setting.directory / "raw").string());
}

std::unique_ptr<Way> raw_zmq_tcp(Setting const& setting)
{
    return std::make_unique<RawZmq>(setting, "tcp://127.0.0.1:" + std::to_string(setting.port));
}

}  // namespace bench
