"""What changes where results would."""

from importlib.metadata import version

from t2l.version import with_extensions


def test_without_extensions_it_is_the_librarys_own():
    assert with_extensions([]) == version("t2l")


def test_it_changes_with_what_any_extension_holds(tmp_path):
    first, second = tmp_path / "a.py", tmp_path / "more"
    second.mkdir()
    first.write_text("A = 1\n")
    (second / "b.py").write_text("B = 1\n")
    found = [with_extensions([first]), with_extensions([first, second])]
    (second / "b.py").write_text("B = 2\n")
    found.append(with_extensions([first, second]))
    assert len({version("t2l"), *found}) == 4
    assert with_extensions([first, second]) == found[-1]
