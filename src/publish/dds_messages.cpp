#include "publish/dds_messages.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string>

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/q_radmin.h>

namespace slipstream {
namespace {

/// Largest message to read: an empty request has 24 bytes.
constexpr std::size_t longest_read = 4096;

struct MessageData : ddsi_serdata {
  MessageData(const ddsi_sertype* of, ddsi_serdata_kind what, SharedMessage content)
      : ddsi_serdata(), message(std::move(content)) {
    ddsi_serdata_init(this, of, what);
  }
  SharedMessage message;
};

const RosMessage& message_of(const ddsi_serdata* data) {
  return *static_cast<const MessageData*>(data)->message;
}

/// Exceptions must not reach DDS, which is C.
ddsi_serdata* make_data(const ddsi_sertype* type, ddsi_serdata_kind kind,
                        const SharedMessage& message) noexcept {
  return new (std::nothrow) MessageData(type, kind, message);
}

/// `copy` writes the message's bytes.
template <class Copy>
ddsi_serdata* read_data(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size,
                        Copy copy) noexcept {
  if (size < 4 || size > longest_read) return nullptr;

  try {
    const auto message = std::make_shared<RosMessage>(size);
    copy(std::span(*message));
    return make_data(type, kind, message);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

/// Fragments ordered by their start; they may overlap.
void copy_fragments(const nn_rdata* fragment, std::span<std::uint8_t> to) {
  std::size_t done = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    const std::size_t begin = fragment->min,
                      end = std::min<std::size_t>(fragment->maxp1, to.size());
    if (end <= done || begin > done) continue;

    // Copy only bytes that no earlier fragment had.
    const unsigned char* bytes = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    std::memcpy(to.data() + done, bytes + (done - begin), end - done);

    done = end;
  }
}

ddsi_serdata_ops make_data_operations() {
  ddsi_serdata_ops make{};
  make.get_size = [](const ddsi_serdata* data) {
    return static_cast<std::uint32_t>(message_of(data).size());
  };

  // Received bytes become a message: from fragments, or from pieces of one packet.
  make.from_ser = [](const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragments,
                     std::size_t size) {
    return read_data(type, kind, size,
                     [&](std::span<std::uint8_t> to) { copy_fragments(fragments, to); });
  };
  make.from_ser_iov = [](const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                         const ddsrt_iovec_t* pieces, std::size_t size) {
    return read_data(type, kind, size, [&](std::span<std::uint8_t> to) {
      for (const ddsrt_iovec_t& piece : std::span(pieces, count)) {
        std::memcpy(to.data(), piece.iov_base, std::min(piece.iov_len, to.size()));
        to = to.subspan(std::min(piece.iov_len, to.size()));
      }
    });
  };

  // Samples are shared messages and are never copied.
  make.from_sample = [](const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
    return make_data(type, kind, *static_cast<const SharedMessage*>(sample));
  };

  // Sending: a copy, or a reference that keeps the message alive.
  make.to_ser = [](const ddsi_serdata* data, std::size_t offset, std::size_t size, void* to) {
    std::memcpy(to, message_of(data).data() + offset, size);
  };
  make.to_ser_ref = [](const ddsi_serdata* data, std::size_t offset, std::size_t size,
                       ddsrt_iovec_t* reference) {
    reference->iov_base = const_cast<std::uint8_t*>(message_of(data).data() + offset);
    reference->iov_len = size;
    return ddsi_serdata_ref(data);
  };
  make.to_ser_unref = [](ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); };

  make.to_sample = [](const ddsi_serdata* data, void* sample, void**, void*) {
    *static_cast<SharedMessage*>(sample) = static_cast<const MessageData*>(data)->message;
    return true;
  };

  make.free = [](ddsi_serdata* data) { delete static_cast<MessageData*>(data); };
  make.print = [](const ddsi_sertype*, const ddsi_serdata*, char* text, std::size_t) {
    *text = 0;
    return std::size_t{0};
  };

  // Messages have no key: all belong to one instance.
  make.eqkey = [](const ddsi_serdata*, const ddsi_serdata*) { return true; };
  make.from_keyhash = [](const ddsi_sertype* type, const ddsi_keyhash*) {
    return make_data(type, SDK_KEY, nullptr);
  };
  make.to_untyped = [](const ddsi_serdata* data) {
    ddsi_serdata* const untyped = make_data(data->type, SDK_KEY, nullptr);
    if (untyped != nullptr) untyped->type = nullptr;
    return untyped;
  };
  make.untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) {
    return true;
  };
  make.get_keyhash = [](const ddsi_serdata*, ddsi_keyhash* key, bool) { *key = {}; };
  return make;
}

ddsi_sertype_ops make_type_operations() {
  ddsi_sertype_ops make{};

  make.version = ddsi_sertype_v0;
  make.free = [](ddsi_sertype* type) {
    ddsi_sertype_fini(type);
    delete type;
  };

  // Types are compared by name.
  make.equal = [](const ddsi_sertype*, const ddsi_sertype*) { return true; };
  make.hash = [](const ddsi_sertype*) { return std::uint32_t{0}; };

  // For loaned samples, which are not used here.
  make.zero_samples = [](const ddsi_sertype*, void*, std::size_t) {};
  make.realloc_samples = [](void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {};
  make.free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {};
  return make;
}

}  // namespace

void pad(RosMessage& message) {
  const std::size_t missing = (4 - message.size() % 4) % 4;
  message.resize(message.size() + missing);
  message[3] = static_cast<std::uint8_t>(missing);  // as in the CDR header
}

dds_entity_t create_message_topic(dds_entity_t participant, const std::string& name,
                                  const std::string& type) {
  static const ddsi_sertype_ops type_operations = make_type_operations();
  static const ddsi_serdata_ops data_operations = make_data_operations();

  auto* made = new ddsi_sertype();
  ddsi_sertype_init_flags(made, type.c_str(), &type_operations, &data_operations,
                          DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  made->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;

  // On success the topic owns the type.
  const dds_entity_t topic =
      dds_create_topic_sertype(participant, name.c_str(), &made, nullptr, nullptr, nullptr);
  if (topic < 0) ddsi_sertype_unref(made);
  return topic;
}

}  // namespace slipstream
