// Reads JSON, as much of it as `treegen inspect --expand` writes: no spaces, no escapes.
#pragma once
#include <charconv>
#include <cstdlib>
#include <iostream>
#include <map>
#include <string>
#include <vector>

[[noreturn]] inline void fail(const std::string &message) {
    std::cerr << "error: " << message << "\n";
    std::exit(2);
}

struct Json {
    double number = 0;
    std::string text;
    std::vector<Json> list;
    std::map<std::string, Json> fields;

    bool has(const std::string &name) const { return fields.count(name) != 0; }

    const Json &operator[](const std::string &name) const {
        auto found = fields.find(name);
        if (found == fields.end()) fail("a line has no `" + name + "`");
        return found->second;
    }
};

class JsonReader {
public:
    explicit JsonReader(const std::string &line) : at(line.data()), end(line.data() + line.size()) {}

    Json value() {
        Json json;
        if (takes('{')) {
            while (!takes('}')) {
                std::string name = string();
                expect(':');
                json.fields.emplace(std::move(name), value());
                takes(',');
            }
        } else if (takes('[')) {
            while (!takes(']')) {
                json.list.push_back(value());
                takes(',');
            }
        } else if (at != end && *at == '"') {
            json.text = string();
        } else if (at != end && *at == 'n') {
            for (char letter : {'n', 'u', 'l', 'l'}) expect(letter);
        } else {
            auto [after, error] = std::from_chars(at, end, json.number);
            if (error != std::errc()) fail("this is no value: " + std::string(at, end).substr(0, 40));
            at = after;
        }
        return json;
    }

private:
    const char *at, *end;

    bool takes(char character) {
        bool there = at != end && *at == character;
        at += there;
        return there;
    }

    void expect(char wanted) {
        if (!takes(wanted)) fail(std::string("a line lacks a `") + wanted + "`");
    }

    std::string string() {
        expect('"');
        const char *begin = at;
        while (at != end && *at != '"') at++;
        std::string text(begin, at);
        expect('"');
        return text;
    }
};
