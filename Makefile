# make deps    install the Debian packages that the build needs
# make build   release build; programs in build/bin
# make test    build, then run every test; the last line is "N passed, N failed, N skipped"
# make fuzz    10 seconds of libFuzzer a target, where clang is installed with it; FUZZ_SECONDS=300 FUZZ_SEED=0 for a longer run with other choices
# make demo    make the demo characters, cook them and render pictures into out
# make figures make the figures of docs/figures.md anew
# make gallery make demo, and the pictures of README.md and docs/gallery.md anew
# make bench   run the benchmarks and write their tables into docs/performance.md
# make clean   remove every build folder

JOBS ?= $(shell nproc)

.PHONY: deps configure build programs test fuzz demo figures gallery bench clean

deps:
	tools/deps.sh

configure:
	cmake --preset release $(if $(shell command -v ccache),-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)

build: configure
	cmake --build build -j $(JOBS)

# What the demo and the figures need: no tests, no benchmarks.
programs: configure
	cmake --build build -j $(JOBS) --target furrow furrow-editor furrow_content furrow_contact_sheet furrow_figures

test: deps build
	tools/test.sh build $(JOBS)

fuzz: deps
	tools/fuzz.sh $(JOBS) $(FUZZ_SECONDS) $(FUZZ_SEED)

demo: deps programs
	tools/demo.sh build/bin build/content out

figures: deps programs
	tools/figures.sh build/bin build/content docs/figures

gallery: demo
	tools/gallery.sh build/bin build/content docs/images out/contact_sheet.png

bench: deps build
	tools/bench.sh build docs/performance.md

clean:
	rm -rf build build-dev build-asan build-clang build-asan-clang build-fuzz out
