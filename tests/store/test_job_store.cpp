// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <barrier>
#include <cmath>
#include <set>
#include <thread>

#include "tests/store/job_store_cases.h"

namespace kiln::test {
namespace {

INSTANTIATE_TEST_SUITE_P(Stores, JobStoreTest, testing::ValuesIn(kJobStoreCases), case_name);

TEST_P(JobStoreTest, SubmittedTwiceIsOneJob) {
    const Submitted first = store_->submit("a", "{}", "e1");
    const Submitted second = store_->submit("a", "{}", "e1");
    EXPECT_TRUE(first.created);
    EXPECT_FALSE(second.created);
    EXPECT_EQ(second.job.state, JobState::queued);
    EXPECT_EQ(store_->counts().queued, 1);
    must_claim("w");
    EXPECT_FALSE(store_->submit("a", "{}", "e1").created) << "running";
    EXPECT_FALSE(store_->claim("w", hours(1), kAttemptsMax));
}

TEST_P(JobStoreTest, HundredConcurrentSubmitsMakeOneJob) {
    constexpr int kThreads = 100;
    auto other = open();
    std::barrier start(kThreads);
    std::atomic<int> created{0};
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < kThreads; ++i)
            threads.emplace_back([&, i] {
                start.arrive_and_wait();
                created += (i % 2 == 0 ? *store_ : *other).submit("a", "{}", "e1").created;
            });
    }
    EXPECT_EQ(created, 1);
    EXPECT_EQ(store_->counts().queued, 1);
}

TEST_P(JobStoreTest, HundredConcurrentResubmitsOfAFailedJobMakeOneJob) {
    store_->submit("a", "{}", "e1");
    const JobRecord job = must_claim("w");
    ASSERT_TRUE(store_->fail("a", job.attempts, "device_failed", "gone"));
    constexpr int kThreads = 100;
    std::barrier start(kThreads);
    std::atomic<int> created{0};
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < kThreads; ++i)
            threads.emplace_back([&] {
                start.arrive_and_wait();
                created += store_->submit("a", "{}", "e1").created;
            });
    }
    EXPECT_EQ(created, 1);
}

TEST_P(JobStoreTest, AnyTextComesBackAsItWas) {
    const std::string odd = std::string("'; DROP TABLE jobs; --\0\n\"\xc3\xa9%s", 28);
    store_->submit(odd, odd + "spec", odd + "engine");
    const JobRecord claimed = must_claim(odd + "worker");
    EXPECT_EQ(claimed.id, odd);
    EXPECT_EQ(claimed.spec, odd + "spec");
    EXPECT_EQ(claimed.engine, odd + "engine");
    EXPECT_EQ(claimed.worker, odd + "worker");
    ASSERT_TRUE(store_->finish(odd, claimed.attempts, odd + "1", odd + "2", odd + "3"));
    const JobRecord done = must_get(odd);
    EXPECT_EQ(done.image_digest, odd + "1");
    EXPECT_EQ(done.image_extension, odd + "2");
    EXPECT_EQ(done.report, odd + "3");
    EXPECT_FALSE(store_->get("jobs"));
}

TEST_P(JobStoreTest, OldestIsClaimedFirstAndNoneTwice) {
    constexpr int kJobs = 200, kThreads = 8;
    for (int i = 0; i < kJobs; ++i) store_->submit("job" + std::to_string(i), "{}", "e1");
    EXPECT_EQ(must_claim("w").id, "job0");
    EXPECT_EQ(must_claim("w").id, "job1");
    std::vector<std::vector<std::string>> claimed(kThreads);
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < kThreads; ++i)
            threads.emplace_back([&, i] {
                auto own = open();
                while (auto job = own->claim("w" + std::to_string(i), hours(1), kAttemptsMax))
                    claimed[static_cast<std::size_t>(i)].push_back(job->id);
            });
    }
    std::set<std::string> distinct;
    std::size_t total = 0;
    for (const auto& ids : claimed) {
        total += ids.size();
        distinct.insert(ids.begin(), ids.end());
    }
    EXPECT_EQ(total, kJobs - 2u);
    EXPECT_EQ(distinct.size(), kJobs - 2u);
}

TEST_P(JobStoreTest, HeldLeaseKeepsOthersAway) {
    store_->submit("a", "{}", "e1");
    const JobRecord job = must_claim("w1", kRunOut);
    EXPECT_EQ(store_->renew("a", job.attempts, hours(1), 0.25, 1e-3), Renewal::held);
    EXPECT_FALSE(store_->claim("w2", hours(1), kAttemptsMax));
    const JobRecord renewed = must_get("a");
    EXPECT_EQ(renewed.progress, 0.25);
    EXPECT_EQ(renewed.standard_error_max, 1e-3);
    EXPECT_EQ(renewed.worker, "w1");
}

TEST_P(JobStoreTest, LeaseLostAndTheLateCompletionIsRefused) {
    store_->submit("a", "{}", "e1");
    const JobRecord stale = must_claim("w1", kRunOut);
    store_->renew("a", stale.attempts, kRunOut, 0.5, 0.1);
    const JobRecord current = must_claim("w2");
    EXPECT_EQ(current.id, "a");
    EXPECT_EQ(current.attempts, stale.attempts + 1);
    EXPECT_EQ(current.note, "worker w1 let its lease run out");
    EXPECT_EQ(current.progress, 0);
    EXPECT_FALSE(current.standard_error_max);

    EXPECT_EQ(store_->renew("a", stale.attempts, hours(1), 0.9, {}), Renewal::lost);
    EXPECT_FALSE(store_->finish("a", stale.attempts, "stale", "exr", "{}"));
    EXPECT_FALSE(store_->fail("a", stale.attempts, "stale", "stale"));
    EXPECT_FALSE(store_->cancelled("a", stale.attempts));
    EXPECT_EQ(must_get("a").state, JobState::running);
    EXPECT_EQ(must_get("a").progress, 0);

    EXPECT_TRUE(store_->finish("a", current.attempts, "good", "exr", "{}"));
    EXPECT_FALSE(store_->finish("a", stale.attempts, "stale", "exr", "{}"));
    EXPECT_FALSE(store_->finish("a", current.attempts, "twice", "exr", "{}"));
    EXPECT_EQ(must_get("a").image_digest, "good");
}

// The token of an attempt from before the job was queued afresh must not open the new attempt.
TEST_P(JobStoreTest, LateCompletionFromBeforeAResubmitIsRefused) {
    store_->submit("a", "{}", "e1");
    const JobRecord stale = must_claim("w1", kRunOut);
    const JobRecord second = must_claim("w2");
    ASSERT_TRUE(store_->fail("a", second.attempts, "device_failed", "gone"));
    ASSERT_TRUE(store_->submit("a", "{}", "e2").created);
    std::set<int> tokens{stale.attempts, second.attempts};
    for (int i = 0; i < kAttemptsMax; ++i) {
        const JobRecord current = must_claim("w3", kRunOut);
        EXPECT_TRUE(tokens.insert(current.attempts).second) << current.attempts << " given twice";
        EXPECT_FALSE(store_->finish("a", stale.attempts, "stale", "exr", "{}"));
    }
}

TEST_P(JobStoreTest, WorkerDiedAndOnlyItsJobsGoBack) {
    for (const char* id : {"a", "b", "c"}) store_->submit(id, "{}", "e1");
    const JobRecord a = must_claim("w1");
    const JobRecord b = must_claim("w2");
    const JobRecord c = must_claim("w1");
    ASSERT_TRUE(store_->finish("c", c.attempts, "digest", "exr", "{}"));
    store_->renew("a", a.attempts, hours(1), 0.5, 0.1);
    EXPECT_EQ(store_->release("w1", "signal 11"), 1);
    EXPECT_EQ(store_->release("w1", "signal 11"), 0);
    const JobRecord released = must_get("a");
    EXPECT_EQ(released.state, JobState::queued);
    EXPECT_EQ(released.note, "signal 11");
    EXPECT_EQ(released.progress, 0);
    EXPECT_EQ(must_get("b").state, JobState::running);
    EXPECT_EQ(must_get("c").state, JobState::done);
    EXPECT_FALSE(store_->finish("a", a.attempts, "stale", "exr", "{}"));
    EXPECT_EQ(must_claim("w3").note, "signal 11");
    EXPECT_EQ(store_->renew("b", b.attempts, hours(1), 0.5, {}), Renewal::held);
}

TEST_P(JobStoreTest, AttemptsRunOutAndTheNoteSaysWhy) {
    store_->submit("a", "{}", "e1");
    for (int i = 0; i < kAttemptsMax; ++i) {
        EXPECT_EQ(must_claim("w").id, "a");
        EXPECT_EQ(store_->release("w", "crash " + std::to_string(i)), 1);
    }
    store_->submit("b", "{}", "e1");
    EXPECT_EQ(must_claim("w").id, "b") << "the failed job must not hide the next one";
    const JobRecord failed = must_get("a");
    EXPECT_EQ(failed.state, JobState::failed);
    EXPECT_EQ(failed.error_code, "attempts_exhausted");
    EXPECT_EQ(failed.error_detail, "crash " + std::to_string(kAttemptsMax - 1));
    EXPECT_GT(failed.finished_ms, 0);
    EXPECT_EQ(failed.attempts, kAttemptsMax);

    EXPECT_TRUE(store_->submit("a", "{}", "e1").created);
    for (int i = 0; i < kAttemptsMax; ++i) {
        EXPECT_EQ(must_claim("w", kRunOut).id, "a") << "attempts count anew";
    }
    EXPECT_FALSE(store_->claim("w", hours(1), kAttemptsMax));
    EXPECT_EQ(must_get("a").error_detail, "worker w let its lease run out");
}

TEST_P(JobStoreTest, CancelQueuedRunningFinishedUnknown) {
    store_->submit("queued", "{}", "e1");
    EXPECT_EQ(store_->cancel("queued"), CancelResult::cancelled);
    EXPECT_EQ(must_get("queued").state, JobState::cancelled);
    EXPECT_EQ(must_get("queued").error_code, "cancelled");
    EXPECT_FALSE(store_->claim("w", hours(1), kAttemptsMax));

    store_->submit("running", "{}", "e1");
    const JobRecord job = must_claim("w");
    EXPECT_EQ(store_->cancel("running"), CancelResult::requested);
    EXPECT_EQ(store_->cancel("running"), CancelResult::requested);
    EXPECT_EQ(must_get("running").state, JobState::running);
    EXPECT_EQ(store_->renew("running", job.attempts, hours(1), 0.5, {}), Renewal::cancel_requested);
    EXPECT_TRUE(store_->cancelled("running", job.attempts));
    EXPECT_EQ(must_get("running").state, JobState::cancelled);
    EXPECT_EQ(store_->renew("running", job.attempts, hours(1), 0.5, {}), Renewal::lost);

    EXPECT_EQ(store_->cancel("running"), CancelResult::already_finished);
    EXPECT_EQ(store_->cancel("nobody"), CancelResult::unknown);
}

TEST_P(JobStoreTest, CancelThatComesTooLateLeavesTheResult) {
    store_->submit("a", "{}", "e1");
    const JobRecord job = must_claim("w");
    EXPECT_EQ(store_->cancel("a"), CancelResult::requested);
    EXPECT_TRUE(store_->finish("a", job.attempts, "digest", "exr", "{}"));
    EXPECT_EQ(must_get("a").state, JobState::done);
    EXPECT_FALSE(must_get("a").cancel_requested);
}

TEST_P(JobStoreTest, CancelledJobWhoseWorkerDiedIsNotRunAgain) {
    store_->submit("released", "{}", "e1");
    must_claim("w1");
    store_->cancel("released");
    EXPECT_EQ(store_->release("w1", "signal 9"), 1);
    EXPECT_EQ(must_get("released").state, JobState::cancelled);

    store_->submit("lapsed", "{}", "e1");
    must_claim("w1", kRunOut);
    store_->cancel("lapsed");
    EXPECT_FALSE(store_->claim("w2", hours(1), kAttemptsMax));
    EXPECT_EQ(must_get("lapsed").state, JobState::cancelled);
}

TEST_P(JobStoreTest, SubmitWithdrawsACancelRequest) {
    store_->submit("a", "{}", "e1");
    const JobRecord first = must_claim("w");
    store_->cancel("a");
    const Submitted again = store_->submit("a", "{}", "e1");
    EXPECT_FALSE(again.created);
    EXPECT_FALSE(again.job.cancel_requested);
    EXPECT_EQ(store_->renew("a", first.attempts, hours(1), 0.5, {}), Renewal::held);

    // The worker had stopped before the cancel was withdrawn: the new client still gets a result.
    EXPECT_TRUE(store_->cancelled("a", first.attempts));
    EXPECT_EQ(must_get("a").state, JobState::queued);
    EXPECT_EQ(must_claim("w").id, "a");
}

TEST_P(JobStoreTest, FailedAndCancelledJobsAreQueuedAfresh) {
    store_->submit("failed", "{}", "e1");
    JobRecord job = must_claim("w");
    store_->renew("failed", job.attempts, hours(1), 0.5, 0.1);
    ASSERT_TRUE(store_->fail("failed", job.attempts, "non_finite", "3 samples"));
    EXPECT_EQ(must_get("failed").state, JobState::failed);
    EXPECT_EQ(must_get("failed").error_code, "non_finite");
    EXPECT_EQ(must_get("failed").error_detail, "3 samples");
    store_->submit("cancelled", "{}", "e1");
    store_->cancel("cancelled");
    for (const char* id : {"failed", "cancelled"}) {
        const Submitted afresh = store_->submit(id, "{\"new\":1}", "e2");
        EXPECT_TRUE(afresh.created) << id;
        EXPECT_EQ(afresh.job.state, JobState::queued);
        EXPECT_EQ(afresh.job.spec, "{\"new\":1}");
        EXPECT_EQ(afresh.job.engine, "e2");
        EXPECT_EQ(afresh.job.progress, 0);
        EXPECT_FALSE(afresh.job.standard_error_max);
        EXPECT_EQ(afresh.job.note, "");
        EXPECT_EQ(afresh.job.error_code, "");
        EXPECT_EQ(afresh.job.error_detail, "");
        EXPECT_EQ(afresh.job.started_ms, 0);
        EXPECT_EQ(afresh.job.finished_ms, 0);
    }
}

TEST_P(JobStoreTest, DoneJobIsKeptUnlessEngineOrBlobIsGone) {
    store_->submit("a", "{}", "e1");
    JobRecord job = must_claim("w");
    ASSERT_TRUE(store_->finish("a", job.attempts, "digest", "exr", "{\"r\":1}"));
    const Submitted same = store_->submit("a", "{}", "e1");
    EXPECT_FALSE(same.created);
    EXPECT_EQ(same.job.state, JobState::done);
    EXPECT_EQ(same.job.report, "{\"r\":1}");

    EXPECT_TRUE(store_->submit("a", "{}", "e2").created) << "another engine";
    EXPECT_EQ(must_get("a").image_digest, "");
    job = must_claim("w");
    ASSERT_TRUE(store_->finish("a", job.attempts, "digest2", "exr", "{}"));

    EXPECT_TRUE(store_->submit("a", "{}", "e2", true).created) << "its blob was evicted";
    EXPECT_FALSE(store_->submit("a", "{}", "e2", true).created) << "queued already";
}

TEST_P(JobStoreTest, QueuedJobTakesTheNewestEngine) {
    store_->submit("a", "{}", "e1");
    EXPECT_FALSE(store_->submit("a", "{}", "e2").created);
    EXPECT_EQ(must_claim("w").engine, "e2");
    EXPECT_FALSE(store_->submit("a", "{}", "e3").created);
    EXPECT_EQ(must_get("a").engine, "e2") << "the running attempt keeps its own";
}

TEST_P(JobStoreTest, RestartKeepsAcceptedRunningAndFinishedJobs) {
    for (const char* id : {"done", "running", "queued"}) store_->submit(id, "{}", "e1");
    JobRecord job = must_claim("w1");
    ASSERT_TRUE(store_->finish("done", job.attempts, "digest", "exr", "{\"r\":1}"));
    const JobRecord running = must_claim("w1");
    const JobRecord before[] = {must_get("done"), must_get("running"), must_get("queued")};
    store_ = nullptr;
    store_ = open();
    for (const JobRecord& old : before) {
        const JobRecord now = must_get(old.id);
        EXPECT_EQ(now.state, old.state) << old.id;
        EXPECT_EQ(now.report, old.report);
        EXPECT_EQ(now.created_ms, old.created_ms);
        EXPECT_EQ(now.finished_ms, old.finished_ms);
    }
    EXPECT_TRUE(store_->finish("running", running.attempts, "digest2", "exr", "{}"));
    EXPECT_EQ(must_claim("w2").id, "queued");
    EXPECT_EQ(store_->counts().done, 2);
}

TEST_P(JobStoreTest, ProgressThatIsNoNumberIsRefusedAndNothingWritten) {
    store_->submit("a", "{}", "e1");
    const JobRecord job = must_claim("w");
    store_->renew("a", job.attempts, hours(1), 0.5, 0.1);
    for (double progress : {std::nan(""), -0.01, 1.01}) {
        const auto error =
            error_of([&] { store_->renew("a", job.attempts, hours(1), progress, 0.2); });
        EXPECT_EQ(error[0], "store_failed") << progress;
        EXPECT_NE(error[1].find("renew"), std::string::npos) << error[1];
    }
    EXPECT_EQ(error_of([&] { store_->renew("a", job.attempts, hours(1), 0.6, std::nan("")); })[0],
              "store_failed");
    EXPECT_EQ(must_get("a").progress, 0.5);
    EXPECT_EQ(must_get("a").standard_error_max, 0.1);
}

TEST(JobState, WordsAndStatesAreOneToOne) {
    for (JobState state : {JobState::queued, JobState::running, JobState::done, JobState::failed,
                           JobState::cancelled})
        EXPECT_EQ(job_state_from(to_word(state)), state);
    EXPECT_EQ(to_word(JobState::cancelled), "cancelled");
    EXPECT_FALSE(job_state_from("Queued"));
    EXPECT_FALSE(job_state_from(""));
}

}  // namespace
}  // namespace kiln::test
