// Objects that the actions of one cook share, such as open files.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <typeindex>
#include <typeinfo>

namespace lightcook::pipeline {

/// One object of each type that some action asks for. May be used from several threads; each object guards itself.
class SharedObjects {
public:
    /// Returns the object of a type, made when it is first asked for. It lives as long as this.
    template <class T>
    T& get() {
        const std::lock_guard lock(mutex_);
        std::shared_ptr<void>& object = objects_[typeid(T)];
        if (!object) object = std::make_shared<T>();
        return *static_cast<T*>(object.get());
    }

private:
    std::mutex mutex_;
    std::map<std::type_index, std::shared_ptr<void>> objects_;
};

}  // namespace lightcook::pipeline
