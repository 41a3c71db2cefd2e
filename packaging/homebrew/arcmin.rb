# For a tap: `brew install OWNER/TAP/arcmin`. Version and hashes are written by packaging/stamp.py.
class Arcmin < Formula
  desc "Accuracy, wear and dynamics of RV (cycloidal) reducers"
  homepage "https://repository.invalid/arcmin"
  version "0.2.0"
  license any_of: ["MIT", "Apache-2.0"]

  on_macos do
    on_arm do
      url "https://repository.invalid/arcmin/releases/download/v0.2.0/arcmin-0.2.0-aarch64-apple-darwin.tar.gz"
      sha256 "0000000000000000000000000000000000000000000000000000000000000000"
    end
    on_intel do
      url "https://repository.invalid/arcmin/releases/download/v0.2.0/arcmin-0.2.0-x86_64-apple-darwin.tar.gz"
      sha256 "0000000000000000000000000000000000000000000000000000000000000000"
    end
  end

  on_linux do
    on_arm do
      url "https://repository.invalid/arcmin/releases/download/v0.2.0/arcmin-0.2.0-aarch64-unknown-linux-gnu.tar.gz"
      sha256 "0000000000000000000000000000000000000000000000000000000000000000"
    end
    on_intel do
      url "https://repository.invalid/arcmin/releases/download/v0.2.0/arcmin-0.2.0-x86_64-unknown-linux-gnu.tar.gz"
      sha256 "0000000000000000000000000000000000000000000000000000000000000000"
    end
  end

  def install
    # The command looks beside itself for the library of FMUs, so it is called where it lies and not through a link.
    libexec.install "arcmin"
    libexec.install Dir["libarcmin_fmu.*"]
    bin.write_exec_script libexec/"arcmin"
    bash_completion.install "completions/bash/arcmin"
    zsh_completion.install "completions/zsh/_arcmin"
    fish_completion.install "completions/fish/arcmin.fish"
    man1.install Dir["man/*.1"]
    doc.install "THIRD-PARTY.html", "CHANGELOG.md"
  end

  test do
    system bin/"arcmin", "new", "design.toml"
    assert_match "pins", shell_output("#{bin}/arcmin check design.toml")
  end
end
