// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tests/store/job_store_cases.h"

namespace kiln::test {

using JobStorePages = JobStoreTest;

namespace {

INSTANTIATE_TEST_SUITE_P(Stores, JobStorePages, testing::ValuesIn(kJobStoreCases), case_name);

std::vector<std::string> all_ids(JobStore& store, std::optional<JobState> state, int limit) {
    std::vector<std::string> ids;
    std::string cursor;
    do {
        const JobPage page = store.list(state, limit, cursor);
        for (const JobRecord& job : page.jobs) ids.push_back(job.id);
        cursor = page.next_cursor;
    } while (!cursor.empty());
    return ids;
}

TEST_P(JobStorePages, EveryJobOnceNewestFirst) {
    std::vector<std::string> expected;
    for (int i = 0; i < 25; ++i) {
        expected.insert(expected.begin(), "job" + std::to_string(i));
        store_->submit(expected.front(), "{}", "e1");
    }
    for (int limit : {1, 3, 5, 24, 25, 26, 1000})
        EXPECT_EQ(all_ids(*store_, {}, limit), expected) << "limit " << limit;
    EXPECT_EQ(store_->list({}, 25, "").next_cursor, "") << "a full last page ends the list";
    EXPECT_NE(store_->list({}, 24, "").next_cursor, "");
}

TEST_P(JobStorePages, StateNarrowsTheList) {
    std::vector<std::string> cancelled;
    for (int i = 0; i < 12; ++i) {
        const std::string id = "job" + std::to_string(i);
        store_->submit(id, "{}", "e1");
        if (i % 3 == 0) {
            store_->cancel(id);
            cancelled.insert(cancelled.begin(), id);
        }
    }
    EXPECT_EQ(all_ids(*store_, JobState::cancelled, 2), cancelled);
    EXPECT_EQ(all_ids(*store_, JobState::queued, 5).size(), 8u);
    EXPECT_TRUE(all_ids(*store_, JobState::done, 5).empty());
}

TEST_P(JobStorePages, JobsThatComeBetweenTwoPagesNeitherRepeatNorHideOthers) {
    for (int i = 0; i < 6; ++i) store_->submit("old" + std::to_string(i), "{}", "e1");
    const JobPage first = store_->list({}, 3, "");
    for (int i = 0; i < 6; ++i) store_->submit("new" + std::to_string(i), "{}", "e1");
    const JobPage second = store_->list({}, 3, first.next_cursor);
    ASSERT_EQ(second.jobs.size(), 3u);
    EXPECT_EQ(second.jobs[0].id, "old2");
    EXPECT_EQ(second.jobs[2].id, "old0");
    EXPECT_EQ(second.next_cursor, "");
}

TEST_P(JobStorePages, PagesLeaveReportsOut) {
    store_->submit("a", "{\"seed\":1}", "e1");
    const JobRecord job = must_claim("w");
    ASSERT_TRUE(store_->finish("a", job.attempts, "digest", "exr", "{\"report\":1}"));
    const JobPage page = store_->list({}, 10, "");
    ASSERT_EQ(page.jobs.size(), 1u);
    EXPECT_EQ(page.jobs[0].spec, "{\"seed\":1}");
    EXPECT_EQ(page.jobs[0].report, "");
    EXPECT_EQ(page.jobs[0].image_digest, "digest");
    EXPECT_EQ(page.jobs[0].state, JobState::done);
}

TEST_P(JobStorePages, CursorThatNoPageGaveIsRefused) {
    store_->submit("a", "{}", "e1");
    store_->submit("b", "{}", "e1");
    const std::string good = store_->list({}, 1, "").next_cursor;
    ASSERT_FALSE(good.empty());
    std::vector<std::string> bad{"x",
                                 "-",
                                 "1",
                                 "1-",
                                 "-1",
                                 "1-2-3",
                                 " 1-2",
                                 "1-2 ",
                                 "-1-2",
                                 "1--2",
                                 "+1-2",
                                 "01-2",
                                 "1-02",
                                 "1-A",
                                 "1' OR 1-2",
                                 "ffffffffffffffffffff-1",
                                 std::string("1-2\0", 4)};
    bad.push_back(good + "g");
    bad.push_back(std::string(1 << 20, '1'));
    for (const std::string& cursor : bad)
        EXPECT_EQ(error_of([&] { store_->list({}, 1, cursor); })[0], "bad_cursor")
            << cursor.substr(0, 80);
    EXPECT_EQ(store_->list({}, 1, good).jobs.at(0).id, "a");
}

TEST_P(JobStorePages, LimitOutsideItsRangeIsRefused) {
    for (int limit : {-1, 0})
        EXPECT_EQ(error_of([&] { store_->list({}, limit, ""); })[0], "bad_limit") << limit;
}

TEST_P(JobStorePages, CountsAgreeWithTheLists) {
    for (int i = 0; i < 20; ++i) store_->submit("job" + std::to_string(i), "{}", "e1");
    for (int i = 0; i < 9; ++i) {
        const JobRecord job = must_claim("w" + std::to_string(i % 2));
        if (i % 3 == 0) store_->finish(job.id, job.attempts, "digest", "exr", "{}");
        if (i % 3 == 1) store_->fail(job.id, job.attempts, "device_failed", "gone");
    }
    store_->cancel("job15");
    store_->submit("job1", "{}", "e1");  // the first failed one, afresh
    store_->release("w1", "signal 9");
    const JobCounts counts = store_->counts();
    const auto length = [&](JobState state) {
        return static_cast<std::int64_t>(all_ids(*store_, state, 1000).size());
    };
    EXPECT_EQ(counts.queued, length(JobState::queued));
    EXPECT_EQ(counts.running, length(JobState::running));
    EXPECT_EQ(counts.done, length(JobState::done));
    EXPECT_EQ(counts.failed, length(JobState::failed));
    EXPECT_EQ(counts.cancelled, length(JobState::cancelled));
    EXPECT_EQ(counts.queued + counts.running + counts.done + counts.failed + counts.cancelled, 20);
    EXPECT_EQ(counts.done, 3);
    EXPECT_EQ(counts.failed, 2);
}

TEST_P(JobStorePages, AgeOfTheOldestQueuedJob) {
    EXPECT_EQ(store_->counts().oldest_queued_ms, 0);
    store_->submit("a", "{}", "e1");
    std::this_thread::sleep_for(milliseconds(20));
    EXPECT_GE(store_->counts().oldest_queued_ms, 20 - 1);  // created_ms is cut to whole ms
    must_claim("w");
    EXPECT_EQ(store_->counts().oldest_queued_ms, 0);
}

}  // namespace
}  // namespace kiln::test
