// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "server/base/bound.h"

namespace kiln {

// Of every request's head; more than HTTP needs and less than hurts.
inline constexpr std::size_t kHeadBytesMax = 16 * 1024;
inline constexpr std::size_t kHeadLinesMax = 64;  ///< header fields, without the request line
inline constexpr std::size_t kPathBytesMax = 256;
inline constexpr std::size_t kTargetBytesMax = 2048;

/// Connections that the kernel completes before they are accepted; the HTTP library's own is 5.
inline constexpr int kBacklogMax = 1024;
/// A refused client that still sends is read this long and far, so that it sees why.
inline constexpr std::chrono::milliseconds kLingerTimeMax{1000};
inline constexpr std::size_t kLingerBytesMax = 4 << 20;
/// Below this rate a client that takes an answer is cut off, however steadily it drips.
inline constexpr std::uint64_t kSendBytesPerSecondMin = 16 * 1024;
/// What a large body may take, beside body_timeout_s.
inline constexpr std::uint64_t kReceiveBytesPerSecondMin = 256 * 1024;
/// Measurements that come in at a time; their temporary files are beside the budget of those kept.
inline constexpr int kMeasurementUploadsMax = 16;
/// Processes that read a measurement, how long another upload waits for one, and what each may use.
inline constexpr int kReadersMax = 2;
inline constexpr std::chrono::seconds kReaderPatienceMax{60};
inline constexpr std::chrono::seconds kReaderTimeMax{60};   ///< of a core
inline constexpr std::chrono::seconds kReaderWaitMax{240};  ///< where cores are scarce
inline constexpr std::uint64_t kReaderMemoryMax = std::uint64_t{2} << 30;
inline constexpr std::size_t kReaderAnswerBytesMax = 8 << 20;
/// Small pieces of an answer that wait for the next large one.
inline constexpr std::size_t kCoalescedBytesMax = 16 * 1024;
/// Of all bodies above a batch's size that are held at one time: scenes.
inline constexpr std::uint64_t kUploadBytesMax = 64 << 20;
/// Scenes that are read at a time, and how long another one waits for its turn.
inline constexpr int kPlansMax = 4;
inline constexpr std::chrono::seconds kPlanPatienceMax{10};
/// Finished jobs whose image's digest is at hand without a look into the store.
inline constexpr std::size_t kImageIndexEntriesMax = 4096;

/// The longest line of a worker to the front: its devices.
inline constexpr std::size_t kWorkerLineBytesMax = 256 * 1024;
/// Between two starts of a worker that keeps dying.
inline constexpr std::chrono::milliseconds kBackoffMax{5000};
/// Time to abandon a job and end, before SIGKILL.
inline constexpr std::chrono::seconds kAbandonTimeMax{3};

Bounds http_bounds();

}  // namespace kiln
