// Starts `emulator dap`, or goes to a run that listens.
const vscode = require("vscode");

class Adapters {
  createDebugAdapterDescriptor(session) {
    if (session.configuration.request === "attach") {
      return new vscode.DebugAdapterServer(session.configuration.port, "127.0.0.1");
    }
    const emulator = vscode.workspace.getConfiguration("c40").get("emulator", "emulator");
    return new vscode.DebugAdapterExecutable(emulator, ["dap"]);
  }
}

// F5 without a launch configuration: the file that is open.
class Configurations {
  resolveDebugConfiguration(_folder, configuration) {
    if (configuration.type || configuration.request || configuration.name) return configuration;
    return { type: "c40", request: "launch", name: "This program", program: "${file}", stopOnEntry: true, stopAtEnd: true };
  }
}

function activate(context) {
  context.subscriptions.push(
    vscode.debug.registerDebugAdapterDescriptorFactory("c40", new Adapters()),
    vscode.debug.registerDebugConfigurationProvider("c40", new Configurations()),
  );
}

module.exports = { activate, deactivate() {} };
