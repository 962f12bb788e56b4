// CURVE keys, which encrypt ZeroMQ connections and tell their ends who the other is (rfc.zeromq.org/spec/26), and the
// files that hold them: certificates as CZMQ and pyzmq write them (rfc.zeromq.org/spec/4, "ZPL"), one NAME.key with the
// public key and one NAME.key_secret with both. Keys are text, Z85, 40 characters.
#pragma once

#include <filesystem>
#include <string>
#include <vector>
#include <zmq.hpp>

namespace risorius {

struct CurveKeyPair {
  std::string public_key, secret_key;
};

/// Who may connect to a socket that listens. `clients` holds public keys; empty: whoever knows our public key.
struct CurveServer {
  CurveKeyPair keys;
  std::vector<std::string> clients;
};

/// With what a socket connects, and whom it trusts.
struct CurveClient {
  CurveKeyPair keys;
  std::string server_public_key;
};

/// From the system's random numbers.
CurveKeyPair make_curve_key_pair();

/// Writes STEM.key and STEM.key_secret, the latter readable by its owner alone. Throws UserError if one of them exists
/// already: a key that is overwritten is lost.
void write_curve_certificate(const std::filesystem::path& stem, const CurveKeyPair& keys);

/// The pair of a .key_secret file. Throws UserError naming the file and the remedy.
CurveKeyPair load_curve_secret(const std::filesystem::path& path);
/// The public key of a .key or .key_secret file.
std::string load_curve_public(const std::filesystem::path& path);
/// The public keys of one .key file, or of all that a folder has. Throws UserError if there is none.
std::vector<std::string> load_curve_clients(const std::filesystem::path& path);

/// "" and "": no CURVE, a server without keys. Throws UserError naming `place` if there are clients and no key.
CurveServer load_curve_server(const std::string& secret_file, const std::string& clients, const std::string& place);

/// Before the socket connects.
void use_curve(zmq::socket_t& socket, const CurveClient& client);

}  // namespace risorius
