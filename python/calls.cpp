#include "calls.hpp"

#include <csignal>
#include <exception>
#include <limits>
#include <memory>

namespace stonestack::python {
namespace {

namespace py = pybind11;

constexpr double kNoLimit = 1e9;  // s, so that a call without a limit asks the clock, too

volatile std::sig_atomic_t ctrl_c = 0;

/// Classes of exceptions; they live as long as the process.
struct ErrorClasses {
  PyObject *error, *argument, *file, *device, *interrupted;
};
ErrorClasses classes{};

bool on_main_thread() {
  return ::getpid() == static_cast<pid_t>(::syscall(SYS_gettid));
}

PyObject* add_class(py::module_& module, const char* name, const char* text, const py::tuple& bases,
                    core::ExitCode code) {
  py::dict members;
  members["exit_code"] = static_cast<int>(code);
  const std::string full = std::string("stonestack.") + name;
  PyObject* made = PyErr_NewExceptionWithDoc(full.c_str(), text, bases.ptr(), members.ptr());
  if (made == nullptr) throw py::error_already_set();
  module.attr(name) = py::handle(made);
  return made;
}

void raise(PyObject* kind, const core::Error& error) {
  const py::object value = py::reinterpret_borrow<py::object>(kind)(error.what());
  value.attr("exit_code") = static_cast<int>(error.exit_code());
  PyErr_SetObject(kind, value.ptr());
}

}  // namespace

double CallClock::now() const {
  return ctrl_c != 0 ? std::numeric_limits<double>::infinity() : core::host_seconds();
}

LongCall::LongCall(double seconds) {
  const auto handler = PyOS_getsig(SIGINT);
  const bool watches = on_main_thread() && handler != SIG_IGN && handler != SIG_DFL;
  if (watches) ctrl_c = 0;
  if (watches || seconds > 0.0) limit_.emplace(seconds > 0.0 ? seconds : kNoLimit, clock_);
  if (!watches) return;
  struct sigaction action {};
  action.sa_handler = [](int) { ctrl_c = 1; };
  installed_ = sigaction(SIGINT, &action, &before_) == 0;
}

LongCall::~LongCall() {
  if (installed_) sigaction(SIGINT, &before_, nullptr);
}

void LongCall::pass_on_interrupt() {
  if (!installed_ || ctrl_c == 0) return;
  sigaction(SIGINT, &before_, nullptr);
  installed_ = false;
  ctrl_c = 0;
  PyErr_SetInterrupt();
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void add_errors(py::module_& module) {
  using core::ExitCode;
  const auto base = [](PyObject* kind) { return py::reinterpret_borrow<py::object>(kind); };
  classes.error =
      add_class(module, "Error",
                "Base of the errors of this library. exit_code: what the command `stonestack` ends with.",
                py::make_tuple(base(PyExc_Exception)), ExitCode::kInternal);
  classes.argument =
      add_class(module, "InvalidArgument", "An argument that cannot be; the message carries the values.",
                py::make_tuple(base(classes.error), base(PyExc_ValueError)), ExitCode::kUsage);
  classes.file = add_class(module, "FileError", "A file that is missing or does not hold what it should.",
                           py::make_tuple(base(classes.error), base(PyExc_OSError)), ExitCode::kUnreadable);
  classes.device = add_class(module, "DeviceError", "A device that does not answer or refuses.",
                             py::make_tuple(base(classes.error)), ExitCode::kExecutionFailed);
  classes.interrupted = add_class(module, "Interrupted", "Work that was ended from outside.",
                                  py::make_tuple(base(classes.error)), ExitCode::kInterrupted);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const core::InvalidArgument& error) {
      raise(classes.argument, error);
    } catch (const core::FileError& error) {
      raise(classes.file, error);
    } catch (const core::DeviceError& error) {
      raise(classes.device, error);
    } catch (const core::Interrupted& error) {
      raise(classes.interrupted, error);
    } catch (const core::Error& error) {
      raise(classes.error, error);
    }
  });
}

}  // namespace stonestack::python
