// SPDX-License-Identifier: MIT
// drop.js: files that people drop or open: maps and paths. Nothing leaves the page.

const kMostBytes = 512 << 20;

class Drop {
  constructor(scene) {
    this.scene = scene;
    const hint = (shown) => { $("drop").hidden = !shown; };
    addEventListener("dragover", (e) => { e.preventDefault(); hint(true); });
    addEventListener("dragleave", (e) => { if (!e.relatedTarget) hint(false); });
    addEventListener("drop", (e) => { e.preventDefault(); hint(false); this.take(e.dataTransfer.files); });
    $("file").addEventListener("change", (e) => { this.take([...e.target.files]); e.target.value = ""; });
  }
  async take(files) {
    for (const file of files) {
      if (/\.txt$/i.test(file.name)) this.scene.openPath(await file.text());
      else await this.map(file);
    }
  }
  async map(file) {
    await this.scene.guard(async () => {
      if (file.size > kMostBytes) throw new Error("The file has " + Math.round(file.size / 2 ** 20) + " MB; this page takes " + (kMostBytes >> 20) + ".");
      const bytes = new Uint8Array(await file.arrayBuffer());
      await this.scene.add({ name: file.name.replace(/\.dgm$/i, ""), bytes: async () => bytes, pictures: [], dropped: true });
    });
  }
}
