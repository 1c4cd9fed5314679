// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace kiln {

/// One SQLite connection. Not safe from two threads at once: its owner holds a mutex around each
/// use.
class Database {
  public:
    /// Created when absent. Throws Error("store_failed").
    explicit Database(const std::string& path);
    ~Database();
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    /// Fixed statements without parameters, none of which gives rows that matter.
    void execute(const char* name, const char* sql);
    std::int64_t changes() const;  ///< rows that the latest statement wrote, triggers aside
    bool in_transaction() const;
    bool busy() const;  ///< the latest call failed because another connection holds the file
    /// Error("store_failed") with `name`, the reason and SQLite's extended code.
    [[noreturn]] void fail(std::string_view name) const;

    sqlite3* handle() const { return handle_; }

  private:
    sqlite3* handle_ = nullptr;
};

/// The rows of one run of a statement; resets the statement and drops its parameters at the end.
/// A statement that writes has committed only once next() gave false: read all rows, always.
class Rows {
  public:
    Rows(Database& database, const char* name, sqlite3_stmt* statement)
        : database_(database), name_(name), statement_(statement) {}
    ~Rows();
    Rows(const Rows&) = delete;
    Rows& operator=(const Rows&) = delete;

    bool next();
    /// Runs a statement to its end.
    void finish() {
        while (next()) {
        }
    }
    bool null(int column) const;
    std::int64_t integer(int column) const;
    double real(int column) const;
    std::string text(int column) const;

  private:
    Database& database_;
    const char* name_;
    sqlite3_stmt* statement_;
};

/// One prepared statement, kept for the life of its connection. Values are only ever bound, never
/// pasted into the text.
class Statement {
  public:
    Statement(Database& database, const char* name, const std::string& sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    /// Binds `values` to ?1, ?2, … in order.
    template <class... Values>
    Rows run(const Values&... values) {
        int index = 0;
        (bind(++index, values), ...);
        return Rows(database_, name_, statement_);
    }

  private:
    void bind(int index, std::int64_t value);
    void bind(int index, int value) { bind(index, std::int64_t{value}); }
    void bind(int index, double value);
    void bind(int index, const std::optional<double>& value);
    void bind(int index, std::string_view value);
    void bind(int index, const std::string& value) { bind(index, std::string_view(value)); }
    void check(int code);

    Database& database_;
    const char* name_;
    sqlite3_stmt* statement_ = nullptr;
};

/// BEGIN IMMEDIATE … COMMIT; rolled back unless committed.
class Transaction {
  public:
    explicit Transaction(Database& database);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void commit();

  private:
    Database& database_;
};

}  // namespace kiln
