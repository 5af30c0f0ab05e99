/// Objects of MRPT in memory.
#pragma once

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <functional>
#include <string>

namespace edge_mcl::test {

/// Reads back an object that was written to an archive in memory.
inline mrpt::serialization::CSerializable::Ptr throughArchive(
    const mrpt::serialization::CSerializable& object) {
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << object;
  stream.Seek(0);
  return archive.ReadObject();
}

/// Reads an object from an archive that is written by hand, in the layout of MRPT's CArchive: the
/// name of the class, the version, the data and an end mark.
/// @param write writes the data.
inline mrpt::serialization::CSerializable::Ptr fromArchive(
    const std::string& class_name, uint8_t version,
    const std::function<void(mrpt::serialization::CArchive&)>& write) {
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << static_cast<uint8_t>(class_name.size() | 0x80);  // the high bit says: with a version
  archive.WriteBuffer(class_name.data(), class_name.size());
  archive << version;
  write(archive);
  archive << static_cast<uint8_t>(0x88);
  stream.Seek(0);
  return archive.ReadObject();
}

}  // namespace edge_mcl::test
